#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"
#include "rubicon/result.hpp"
#include "rubicon/tuple.hpp"
#include "tuples/peis/tuple_wire.h"

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

/// A value as tuples on the wire carry it.
struct WireValue {
  Encoding encoding = Encoding::kAscii;
  std::string data;  ///< not empty
};

/// Text (media type `text/...`, or UTF-8 without NUL) is ASCII with one NUL more, as the string functions of kernels
/// store it (peis.md, section 1.1); an empty value is one NUL, since kernels drop tuples without data (section 6.2, 9).
WireValue to_wire(std::string_view value, std::string_view media_type);

/// The opposite, for what a component of ours sent: exactly the value that to_wire() received.
std::string_view from_wire(Encoding encoding, std::string_view data);

/// The same for what a kernel sent. It keeps the encoding of the first set (section 6.2, 18), so that ASCII may be
/// binary: data with another NUL inside is left as it is, unless the media type is `text/...`.
std::string_view from_kernel(Encoding encoding, std::string_view data, std::string_view media_type);

/// The data of a tuple after an append, as kernels do it (section 1.6): ASCII replaces the trailing NUL.
std::string appended(Encoding encoding, std::string_view data, std::string_view difference);

/// The creator of a tuple on the wire: the owner for one without an id, or with an id above 2^31-1, which kernels take
/// for a negative one. Components of the other engines may have such ids.
OwnerId creator_on_wire(OwnerId creator, OwnerId owner);

/// `text/plain` for none, cut to kMaxMediaType bytes.
std::string_view media_type_on_wire(std::string_view media_type);

/// An own tuple without its sequence. It refers to the texts of both arguments, which must outlive it.
NetworkTuple tuple_on_wire(const TupleView& tuple, const WireValue& value, OwnerId self);

}  // namespace rubicon::tuples::peis
