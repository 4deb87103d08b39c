#include <cstdlib>

#include "fuzz_target.h"
#include "trust/site/site_folder.h"
#include "trust/site/site_proofs.h"

namespace rubicon::fuzz::site_realm_fuzz {

namespace {

using namespace rubicon::trust;
using namespace rubicon::trust::site;

constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);

struct Signer {
  PrivateKey key;
  Certificate certificate;
};

/// Of the realm that an input names.
Signer signer_of(const std::string& realm) {
  auto key = PrivateKey::make();
  auto certificate = make_site_authority(realm, kNow + std::chrono::days(9), *key);
  return {std::move(*key), std::move(*certificate)};
}

}  // namespace

/// Input: a signed realm, which no key of this process signed, or the text inside of a signature.
FUZZ_TARGET(site_realm) {
  static const auto signer = signer_of("Fuzz");
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (read_realm(text, signer.certificate, "input")) std::abort();
  auto realm = parse_realm(text, "input");
  if (!realm && realm.error().text.empty()) std::abort();
  if (!realm) return 0;
  realm->name = "Fuzz";
  const auto document = sign_realm(*realm, signer.certificate, signer.key);
  if (!document) {
    if (document.error().code != ErrorCode::kBusy) std::abort();
    return 0;
  }
  const auto again = read_realm(*document, signer.certificate, "again");
  if (!again || *again != *realm) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::site_realm_fuzz
