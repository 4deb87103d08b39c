#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon/layout.h"
#include "base/local_time.h"
#include "base/printable.h"
#include "rubicon/time.hpp"

namespace rubicon::cli {

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
