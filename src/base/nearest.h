#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rubicon::base {

/// Letters to insert, delete, replace, or swap with their neighbour to make one word of the other; ASCII letters count
/// as equal in both cases. Cost: the product of the lengths.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidates that `word` may be a slip of, the nearest first, equal ones in the order given: one slip in up to
/// five letters, two in up to eight, three beyond; then those that begin with it (three letters or more). At most
/// `most`, none twice, none for a word of more than 100 bytes.
std::vector<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates,
                                 std::size_t most = 3);

/// `did you mean 'a', 'b' or 'c'?` for a message; empty if nothing is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace rubicon::base
