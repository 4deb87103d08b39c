#include <cstdlib>

#include "fuzz_target.h"
#include "trust/realm.h"
#include "trust/signed_text.h"

namespace rubicon::fuzz::trust_revoked_fuzz {

namespace {

using namespace rubicon::trust;

constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);

const Authority& authority() {
  static const auto made = Authority::make("Fuzz", kNow);
  return *made;
}

}  // namespace

/// Input: a signed list, which no key of this process signed, or the text inside of a signature.
FUZZ_TARGET(trust_revoked) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto& signer = authority().realm.permissions_ca;
  if (read_revoked(text, signer, "input")) std::abort();
  const auto list = parse_revoked(text, "input");
  if (!list && list.error().text.empty()) std::abort();
  if (!list) return 0;
  const auto document = sign_revoked(*list, signer, authority().permissions_key);
  if (!document) std::abort();
  const auto again = read_revoked(*document, signer, "again");
  if (!again || *again != *list) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::trust_revoked_fuzz
