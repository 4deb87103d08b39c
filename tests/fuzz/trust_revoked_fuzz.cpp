#include <cstdlib>

#include "trust/realm.h"
#include "trust/signed_text.h"

namespace {

using namespace rubicon;
using namespace rubicon::trust;

constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);

const Authority& authority() {
  static const auto made = Authority::make("Fuzz", kNow);
  return *made;
}

}  // namespace

/// Input: a signed list, which no key of this process signed, or the text inside of a signature.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
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
