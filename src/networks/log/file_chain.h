#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "networks/log/recording.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

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

/// The files that the configured paths name, in playing order. Relative paths start at `directory`. A last part with
/// `*` and `?` is a pattern for file names, sorted in natural order (2 before 10). kNotFound if no file matches it.
Result<std::vector<std::string>> list_files(const std::vector<std::string>& configured, const std::string& directory);

/// Whether a file name matches a pattern with `*` (any number of characters) and `?` (one character).
bool matches_wildcard(std::string_view pattern, std::string_view name);

/// Compares names; numbers in them compare as numbers.
bool natural_less(std::string_view left, std::string_view right);

/// The last number in a file's name, as text without leading zeros; empty if there is none.
std::string number_in_name(std::string_view path);

/// Reads files one after the other, in pieces of 64 KiB, through a recording format.
class FileChain {
 public:
  enum class Found { kStep, kNextFile, kNothingYet, kEnd };

  FileChain(transport::Transports& transports, Recording& recording);

  /// Opens the first of these files; after a failure, the one that failed.
  Result<void> open(std::vector<std::string> files);
  /// Opens the first file again.
  Result<void> rewind();
  /// Reads at most one piece. kStep: `step` is filled; kNextFile: the next file begins; kNothingYet: call it again.
  Result<Found> next(Step& step);

  const std::string& path() const { return files_[index_]; }

 private:
  Result<void> open_current();
  Result<std::string> label_of(const std::string& table, const std::string& key);

  transport::Transports& transports_;
  Recording& recording_;
  std::vector<std::string> files_;
  std::string directory_;
  std::size_t index_ = 0;
  std::unique_ptr<transport::FileSource> file_;
  Bytes piece_;
  bool ended_ = false;
};

}  // namespace rubicon::networks::log
