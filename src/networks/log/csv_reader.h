#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"

namespace rubicon::networks::log {

/// Longest line that is looked at; a longer one is skipped and reported.
inline constexpr std::size_t kMaxLine = 64UL * 1024;

/// A line of a text file without its line end (LF or CR LF), or the fact that it was too long.
struct TextLine {
  std::uint64_t offset = 0;
  std::uint64_t number = 0;  ///< counts from 1
  std::uint64_t bytes = 0;   ///< with the line end
  bool too_long = false;     ///< then without text
  std::string text;
};

/// Takes a text file in pieces of any size and gives its lines: byte order mark dropped, the last line end may be
/// missing, memory bounded whatever the lines are.
class LineReader {
 public:
  /// Appends bytes; call next() until it gives nothing before feeding more.
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

/// Splits a line at any of the separators. A blank in the set separates only lines that hold none of the others;
/// blanks around cells are dropped, a run of them counts as one. A cell in double quotes may hold separators.
void split_cells(std::string_view line, std::string_view separators, std::vector<std::string_view>& cells);

}  // namespace rubicon::networks::log
