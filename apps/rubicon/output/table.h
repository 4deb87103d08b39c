#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/clocks.h"
#include "base/text.h"
#include "rubicon/time.hpp"

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

/// `6541:proxy.dum…illuminance-1.value`: shortened to this number of characters; more of the end stays than of the
/// beginning.
std::string shortened(std::string_view text, std::size_t width);
/// The text in lines of at most so many characters, broken at blanks and `|` where possible; width 0 = one line. Never
/// empty.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);
/// The length of the longest word, in characters. Blanks separate words.
std::size_t longest_word_in(std::string_view text);

/// How a text for people looks.
struct Look {
  bool colour = false;
  std::size_t width = 0;  ///< of a line, in characters; 0 = as long as it is
};

using base::printable;
/// UTF-8 characters (broken bytes count as one each).
using base::characters;

/// Rows below heads, aligned. Cells are made printable. On a screen no line is longer than it: keys are shortened in
/// the middle, texts and values wrapped; columns that do not fit even so are named below the table.
class Table {
 public:
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}
  /// Missing cells are empty.
  void row(std::vector<std::string> cells);
  bool empty() const { return rows_.empty(); }
  std::size_t size() const { return rows_.size(); }
  /// Lines with their ends; cells that begin with a word for a bad quality or outcome are painted.
  std::string text(const Look& look) const;

 private:
  Widths widths(std::size_t width) const;
  void add_row(const std::vector<std::string>& row, const Widths& widths, const Look& look, bool head,
               std::string& out) const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// The word between escape sequences that fit its meaning (stale: yellow, refused: red), or as it is.
std::string painted(const std::string& word, const std::string& shown, bool colour);
std::string bold(const std::string& text, bool colour);

using base::age_text;
/// `2026-01-31 12:00:00.250 CET`, local time; `-` for zero.
std::string time_text(WallTime time);
/// `12:00:00.250 CET`, local time.
std::string clock_text(WallTime time);
/// `1 tuple`, `3 tuples`.
std::string counted(std::size_t count, std::string_view what);

}  // namespace rubicon::cli
