#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::groups {

/// One row of a CSV file: undecoded bytes without the quotes.
struct CsvRecord {
  std::size_t line = 0;  ///< its first line, from 1
  std::vector<std::string> fields;
  bool cut = false;     ///< it has more than 64 columns, the others are left out
  bool broken = false;  ///< a quote has no end: `fields` is read from the first line only
};

/// Splits a file into rows: quotes, `""` in them, line breaks in them; CRLF, LF or CR. A quote without an end
/// breaks its own line only, up to a bound of such lines. The text must outlive it.
class CsvRecords {
 public:
  CsvRecords(std::string_view text, char delimiter);
  /// The next row; false at the end. Empty lines give rows with one empty field.
  bool next(CsvRecord& out);
  /// True if the rest was not read, because too many lines had a quote without an end.
  bool gave_up() const { return gave_up_; }

 private:
  enum class End { kField, kRecord, kBroken };
  End read_field(std::string& out);
  End read_quoted(std::string& out);
  bool at_end() const { return at_ >= text_.size(); }
  bool at_break() const { return text_[at_] == '\n' || text_[at_] == '\r'; }
  void skip_break();
  void skip_line();

  std::string_view text_;
  char delimiter_;
  std::size_t at_ = 0, line_ = 1, begin_ = 0, broken_ = 0;
  bool gave_up_ = false;
};

/// The delimiter of a file: the most frequent one outside quotes in its first line that is not empty; 0 = none.
char delimiter_of(std::string_view text);

/// The columns of an ETS CSV export.
struct CsvLayout {
  bool header = false;
  std::size_t names = 1;          ///< number of name columns, the first ones: 1; 2 = main, sub; 3 = main, middle, sub
  std::size_t address = 0;        ///< the first column of the address
  std::size_t address_parts = 1;  ///< number of columns of the address
  std::optional<std::size_t> central{}, unfiltered{}, description{}, comment{}, type{}, security{};
  wire::Notation notation = wire::Notation::kThreeLevel;

  /// `3/1`: names in three columns, addresses in one.
  std::string form() const;
};

/// Finds the layout by the words of the header and by the content of the first rows, which also works for headers in
/// other languages; nullopt if no column holds addresses. The rows need not be decoded.
std::optional<CsvLayout> find_layout(std::span<const CsvRecord> first_rows);

/// The address of a row as one text: `1/0/7`, `1/0/-`; missing parts become `-`.
std::string address_text(const CsvRecord& row, const CsvLayout& layout);

}  // namespace rubicon::networks::knx::groups
