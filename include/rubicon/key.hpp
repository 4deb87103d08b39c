#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::model {

/// A key is a sequence of parts joined by dots; a part is `[A-Za-z0-9_-]+`, case-sensitive. The limits also apply to
/// patterns.
inline constexpr std::size_t kMaxKeyLength = 255;  ///< bytes
inline constexpr std::size_t kMaxKeyParts = 12;

/// kInvalid if it is not a key; the text names the position of the fault and quotes the key.
Result<void> check_key(std::string_view key);

/// Makes one key part of any text: replaces each character that a part may not contain by `_`, and cuts at `limit`
/// bytes. An empty text becomes `_`.
std::string to_key_part(std::string_view text, std::size_t limit = 64);

/// Untrusted text in quotation marks, for error messages: control characters are escaped, long texts are cut after 60
/// characters.
std::string quoted(std::string_view text);

/// The parts of a valid key or pattern, as views into it.
std::vector<std::string_view> key_parts(std::string_view key);

/// Selects tuples by owner and key. In the key, the part `*` stands for exactly one part; the last part may be `**`,
/// which stands for any number of parts, also none. Text form: `proxy.*.status` or `*:proxy.*.status` (any owner),
/// `6541:proxy.**`.
struct Pattern {
  std::optional<OwnerId> owner;  ///< empty = any
  std::string key;

  /// kInvalid if the text is not of that form.
  static Result<Pattern> parse(std::string_view text);
  bool matches(OwnerId tuple_owner, std::string_view tuple_key) const;
  /// The key has no wildcard.
  bool exact() const;

  friend bool operator==(const Pattern&, const Pattern&) = default;
};

std::string to_string(const Pattern& pattern);

}  // namespace rubicon::model

namespace rubicon {
using model::Pattern;
}  // namespace rubicon
