#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace rubicon::cli {

/// One column of a table, and how it gives way where the lines are too short for all.
struct Column {
  enum class Kind {
    kWord,   ///< never shorter than it is: a number, a word
    kKey,    ///< shortened in the middle
    kText,   ///< wrapped at blanks
    kValue,  ///< wrapped too, and gets its room before the others
  };
  Column(const char* a_head, Kind a_kind = Kind::kWord, unsigned a_rank = 0)
      : head(a_head), kind(a_kind), rank(a_rank) {}

  std::string head;
  Kind kind = Kind::kWord;
  /// Which column is left out first where even the shortest form of all does not fit: the highest; 0 = never.
  unsigned rank = 0;
};

struct Widths {
  std::vector<std::size_t> of;        ///< characters of each column; 0 = it is left out
  std::vector<std::string> left_out;  ///< heads
};

/// `longest`: of each column, of its cells and its head. `longest_word`: the same, of their words. `width` 0 = no
/// bound.
Widths widths_of(const std::vector<Column>& columns, const std::vector<std::size_t>& longest,
                 const std::vector<std::size_t>& longest_word, std::size_t width);

/// `6541:proxy.dum…illuminance-1.value`: at most so many characters, more of the end than of the beginning.
std::string shortened(std::string_view text, std::size_t width);
/// The text in lines of at most so many characters, broken at blanks and `|` where possible; width 0 = one line. Never
/// empty.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);
/// Of words between blanks, in characters.
std::size_t longest_word_in(std::string_view text);

}  // namespace rubicon::cli
