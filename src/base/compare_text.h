#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace rubicon::base {

/// Finds std::string keys by string_view without a copy.
struct TextHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
};

template <class T>
using ByText = std::unordered_map<std::string, T, TextHash, std::equal_to<>>;

/// `*` stands for any text, `?` for any one byte; everything else for itself. Linear in the text for each `*`.
bool glob_matches(std::string_view pattern, std::string_view text);

/// The order in which people list ids: runs of digits count as numbers (`wsn-2` before `wsn-10`, `1_0_7` before
/// `1_0_12`). A word of 16 hexadecimal digits, with or without `0x` before it, is an IEEE address and no number:
/// addresses stand behind numbers, in the order of their texts. All else byte by byte.
bool natural_less(std::string_view a, std::string_view b);

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
