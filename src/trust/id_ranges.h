#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "tuples/member.h"

namespace rubicon::trust {

// The ids of members (docs/trust.md): an island has its id and a block, all others a block of 2^20 ids.

inline constexpr std::uint32_t kLastBlock = 0x7ff;
inline constexpr std::size_t kMostRanges = 8;  ///< of a certificate

/// Block k of 1..kLastBlock: `k00000..kfffff` in hexadecimal digits.
constexpr tuples::IdRange block_range(std::uint32_t block) {
  return {block << 20U, block << 20U | 0xfffffU};
}
/// The number of the block, if the range is one; else 0.
constexpr std::uint32_t block_of(const tuples::IdRange& range) {
  const auto block = range.first >> 20U;
  return block >= 1 && block <= kLastBlock && block_range(block) == range ? block : 0;
}

/// `00000007-00000007,01a00000-01afffff`.
std::string ranges_text(const std::vector<tuples::IdRange>& ranges);
/// The reverse: 1..kMostRanges ranges of 1..0x7fffffff, in lower-case digits. The error says what is wrong with the
/// text.
Result<std::vector<tuples::IdRange>> parse_ranges(std::string_view text);

/// The ids as a pattern of fnmatch, for partitions: `00000007`, `01a?????`. kUnsupported if the range is neither one id
/// nor a block.
Result<std::string> id_pattern(const tuples::IdRange& range);

/// `admin,panel`, and the reverse: at most 256 characters, each a role (check_role()), none twice. Empty = none.
std::string roles_text(const std::vector<std::string>& roles);
Result<std::vector<std::string>> parse_roles(std::string_view text);

}  // namespace rubicon::trust
