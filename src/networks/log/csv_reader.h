#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"

namespace rubicon::networks::log {

/// Longer lines are skipped and reported.
inline constexpr std::size_t kMaxLine = 64UL * 1024;

/// A line of a text file without its line end (LF or CR LF).
struct TextLine {
  std::uint64_t offset = 0;
  std::uint64_t number = 0;  ///< from 1
  std::uint64_t bytes = 0;   ///< with the line end
  bool too_long = false;     ///< `text` is then empty
  std::string text;
};

/// Splits a text file, fed in pieces of any size, into lines. Drops a byte order mark; the last line end may be
/// missing. Memory is bounded however long the lines are.
class LineReader {
 public:
  /// Appends bytes. Call it when next() returned nothing.
  void feed(ByteView bytes);
  void end() { ended_ = true; }
  std::optional<TextLine> next();

 private:
  TextLine take_line(std::size_t end, std::size_t line_end);
  void drop_front(std::size_t count);

  std::string buffer_;
  std::size_t position_ = 0;
  std::uint64_t base_ = 0;  ///< file offset of buffer_[0]
  std::uint64_t number_ = 0;
  std::uint64_t long_offset_ = 0;
  bool in_long_line_ = false;
  bool ended_ = false;
};

/// Splits a line at each of the separators. A blank among them separates only in lines without the others, and several
/// blanks count as one. Blanks around cells are dropped. A cell in double quotes may contain separators.
void split_cells(std::string_view line, std::string_view separators, std::vector<std::string_view>& cells);

}  // namespace rubicon::networks::log
