#include <cstdlib>

#include "fuzz_target.h"
#include "trust/site/site_members.h"
#include "trust/site/site_proofs.h"

namespace rubicon::fuzz::site_bundle_fuzz {

using namespace rubicon::trust::site;

/// Input: a bundle; also tried as lines of a password file, and as a hash.
FUZZ_TARGET(site_bundle) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto bundle = read_site_bundle(text)) {
    const auto again = read_site_bundle(bundle_text(*bundle));
    if (!again || again->realm != bundle->realm || again->brokers != bundle->brokers) std::abort();
  } else if (bundle.error().text.empty()) {
    std::abort();
  }
  if (const auto lines = parse_passwords(text, "input")) {
    const auto again = parse_passwords(passwords_text(*lines), "again");
    if (!again || *again != *lines) std::abort();
  }
  if (text.size() < 200 && text.substr(0, 6) == "$7$101" && is_password_of("x", text)) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::site_bundle_fuzz
