#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rubicon::base {

/// Edit distance: letters to insert, delete, replace or swap with their neighbour to turn one word into the other,
/// ignoring the case of ASCII letters. Cost: the product of the lengths.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidates that `word` may be a misspelling of, nearest first, equally near ones in the given order: one error
/// in up to five letters, two in up to eight, three beyond; then those that begin with it (three letters or more). At
/// most `most`, without duplicates; none for a word of more than 100 bytes.
std::vector<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates,
                                 std::size_t most = 3);

/// `did you mean 'a', 'b' or 'c'?` for a message; empty if nothing is near, or if the word itself is one of them: then
/// something else is wrong.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace rubicon::base
