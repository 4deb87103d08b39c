#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"
#include "rubicon/result.hpp"

namespace rubicon::tuples::peis {

// Keys and patterns of ours and of kernels (peis.md, sections 1.2 and 6.2, 19). Kernels have no `**`, at most 7 parts
// and 127 characters, and ignore the case of ASCII letters.

inline constexpr std::size_t kMaxPeisParts = 7;  ///< kernels drop further ones silently
/// Of kernels: matches every key.
inline constexpr std::string_view kEveryKey;

/// ASCII letters in lower case: equal for keys that are equal to kernels.
std::string folded(std::string_view key);
/// Whether folded() would change nothing.
bool is_folded(std::string_view key);

/// kOutOfRange, with the limit in the text: a kernel cannot have a tuple or subscription with this key.
Result<void> check_peis_key(std::string_view key);

/// The keys to subscribe to at a kernel for the key of a Pattern: one for each depth of `**`. Empty: no key of a kernel
/// matches it.
std::vector<std::string> to_kernel_patterns(std::string_view key);

/// The key of a Pattern for a subscription of a kernel. kInvalid: `*` with other characters in one part, characters
/// that no key of ours has.
Result<std::string> from_kernel_pattern(std::string_view key);

/// Whether the key of a Pattern matches, as kernels compare.
bool matches_folded(std::string_view pattern, std::string_view key);

/// What all folded keys that match a folded pattern begin with.
std::string_view literal_begin(std::string_view pattern);

/// Calls `visit` with the iterator of each item whose key matches. The map is ordered by folded keys, and must not
/// change meanwhile.
template <class Map, class Visit>
void each_match(Map& map, std::string_view pattern, Visit visit) {
  const auto wanted = folded(pattern);
  if (wanted.find('*') == wanted.npos) {
    if (const auto found = map.find(wanted); found != map.end()) visit(found);
    return;
  }
  const auto begin = literal_begin(wanted);
  for (auto at = map.lower_bound(begin); at != map.end() && at->first.starts_with(begin); ++at) {
    if (matches_folded(wanted, at->first)) visit(at);
  }
}

/// The pattern with its literal parts in the case that they have in the key, which matches_folded().
std::string spelled_as(std::string_view pattern, std::string_view key);

}  // namespace rubicon::tuples::peis
