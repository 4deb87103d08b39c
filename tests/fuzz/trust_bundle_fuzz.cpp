#include <cstdlib>

#include "fuzz_target.h"
#include "trust/bundle.h"
#include "trust/certificate_request.h"

namespace rubicon::fuzz::trust_bundle_fuzz {

/// Input: a bundle, or a request for a certificate. The seeds are of one realm: whatever is accepted must be of it.
FUZZ_TARGET(trust_bundle) {
  using namespace rubicon;
  using namespace rubicon::trust;
  constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto request = CertificateRequest::of_pem(text, "input");
  if (request && !check_member_name(request->name())) std::abort();
  const auto bundle = read_bundle(text);
  const auto contents = inspect(text, kNow);
  if (!contents && contents.error().text.empty()) std::abort();
  if (contents && (!bundle || !contents->realm.name.starts_with("Seed ") || contents->member.name != "desk"))
    std::abort();
  if (!bundle) return 0;
  const auto again = read_bundle(bundle_text(*bundle));
  if (!again || again->key != bundle->key || again->papers.certificate.text != bundle->papers.certificate.text)
    std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::trust_bundle_fuzz
