#pragma once

#include <vector>

#include "networks/knx/secure/key.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::secure {

/// The key of a password. Interfaces disagree on letters beyond ASCII (knx.md, section 21.4): most take ISO 8859-1,
/// some replace each of them by `?`, some each of its bytes in UTF-8.
struct PasswordKey {
  Key key;
  /// With these replacements; only for a password that has such letters. To be tried in turn after `key` was refused.
  std::vector<Key> others{};

  /// 1 without letters beyond ASCII.
  std::size_t forms() const { return 1 + others.size(); }
  const Key& form(std::size_t index) const { return index == 0 || others.empty() ? key : others.at(index - 1); }
};

/// From a password in UTF-8. Each key takes PBKDF2 (some 15 ms): not for the event loop. A password that ISO 8859-1
/// cannot write (`€`) has only the keys of the replacements. kInvalid: not UTF-8; the error never holds the password.
Result<PasswordKey> user_key(const Secret& password);
/// Proves the interface to us: "authentication code" of the device in ETS.
Result<PasswordKey> device_code(const Secret& password);

/// What ETS 6 gives to the archive of a protected project as its password (knx.md, section 13.4): 44 characters of
/// base64 from a password in UTF-8. One PBKDF2. kInvalid: not UTF-8.
Result<Secret> archive_password(const Secret& password);

}  // namespace rubicon::networks::knx::secure
