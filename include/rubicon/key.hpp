#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::model {

/// Keys are parts joined by dots; a part is `[A-Za-z0-9_-]+`, case sensitive. The bounds hold for patterns too.
inline constexpr std::size_t kMaxKeyLength = 255;
inline constexpr std::size_t kMaxKeyParts = 12;

/// kInvalid with the position and what stands there (control characters escaped, long keys shortened).
Result<void> check_key(std::string_view key);

/// Any text -> one key part: other characters become `_`, cut at `limit`, empty becomes `_`.
std::string to_key_part(std::string_view text, std::size_t limit = 64);

/// Text of outsiders for error messages: printable, at most 60 characters.
std::string quoted(std::string_view text);

/// The parts of a checked key or pattern, as views into it.
std::vector<std::string_view> key_parts(std::string_view key);

/// Which tuples: an owner, or any, and a key whose parts may be `*` (exactly one part), the last one `**` (the rest,
/// also none). Text form: `proxy.*.status`, `6541:proxy.**`; `*:` in front also means any owner.
struct Pattern {
  std::optional<OwnerId> owner;
  std::string key;

  static Result<Pattern> parse(std::string_view text);
  bool matches(OwnerId of, std::string_view concrete) const;
  /// No wildcard in the key.
  bool exact() const;

  friend bool operator==(const Pattern&, const Pattern&) = default;
};

std::string to_string(const Pattern& pattern);

}  // namespace rubicon::model

namespace rubicon {
using model::Pattern;
}  // namespace rubicon
