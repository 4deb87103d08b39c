#include "trust/id_ranges.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "base/printable.h"
#include "base/text.h"
#include "trust/operations.h"

namespace rubicon::trust {

namespace {

constexpr std::size_t kDigits = 8;
constexpr std::size_t kRangeSize = 2 * kDigits + 1;
constexpr std::uint32_t kLastId = 0x7fffffff;
constexpr std::size_t kLongestRoles = 256;

/// Eight lower-case hexadecimal digits.
std::optional<std::uint32_t> parse_id(std::string_view text) {
  if (text.size() != kDigits || text.find_first_not_of("0123456789abcdef") != text.npos) return {};
  return base::parse_hex_number<std::uint32_t>(text);
}

std::optional<tuples::IdRange> parse_range(std::string_view text) {
  if (text.size() != kRangeSize || text[kDigits] != '-') return {};
  const auto first = parse_id(text.substr(0, kDigits));
  const auto last = parse_id(text.substr(kDigits + 1));
  if (!first || !last || *first == 0 || *first > *last || *last > kLastId) return {};
  return tuples::IdRange{*first, *last};
}

/// The pieces between commas; a text without a comma is one piece.
std::vector<std::string_view> pieces_of(std::string_view text) {
  std::vector<std::string_view> pieces;
  while (true) {
    const auto comma = text.find(',');
    pieces.push_back(text.substr(0, comma));
    if (comma == text.npos) return pieces;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

std::string ranges_text(const std::vector<tuples::IdRange>& ranges) {
  std::string text;
  for (const auto& range : ranges)
    text += fmt::format("{}{:08x}-{:08x}", text.empty() ? "" : ",", range.first, range.last);
  return text;
}

Result<std::vector<tuples::IdRange>> parse_ranges(std::string_view text) {
  std::vector<tuples::IdRange> ranges;
  if (text.size() > kMostRanges * (kRangeSize + 1))
    return fail(ErrorCode::kInvalid, fmt::format("has more than {} ranges of ids", kMostRanges));
  for (const auto piece : pieces_of(text)) {
    const auto range = parse_range(piece);
    if (!range || ranges.size() == kMostRanges)
      return fail(ErrorCode::kInvalid,
                  fmt::format("has the ids `{}`: expected at most {} ranges like 01a00000-01afffff",
                              base::one_line(text), kMostRanges));
    ranges.push_back(*range);
  }
  return ranges;
}

Result<std::string> id_pattern(const tuples::IdRange& range) {
  if (range.first == range.last) return fmt::format("{:08x}", range.first);
  if (const auto block = block_of(range); block != 0) return fmt::format("{:03x}?????", block);
  return fail(ErrorCode::kUnsupported,
              fmt::format("the ids {} are neither one id nor a block of 2^20", ranges_text({range})));
}

std::string roles_text(const std::vector<std::string>& roles) {
  return fmt::format("{}", fmt::join(roles, ","));
}

Result<std::vector<std::string>> parse_roles(std::string_view text) {
  std::vector<std::string> roles;
  if (text.empty()) return roles;
  if (text.size() > kLongestRoles)
    return fail(ErrorCode::kInvalid, fmt::format("has roles of more than {} characters", kLongestRoles));
  for (const auto role : pieces_of(text)) {
    if (auto checked = check_role(role); !checked) return fail(checked.error());
    if (std::find(roles.begin(), roles.end(), role) != roles.end())
      return fail(ErrorCode::kInvalid, fmt::format("has the role `{}` twice", role));
    roles.emplace_back(role);
  }
  return roles;
}

}  // namespace rubicon::trust
