#include "networks/knx/groups/csv_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list_builder.h"

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::size_t kMaxFields = 64;
/// In a row longer than this a quote has no end.
constexpr std::size_t kMaxRecordBytes = 128UL * 1024;
/// After this many quotes without an end the rest of the file is not read. Bounds the time.
constexpr std::size_t kMaxBroken = 1000;

}  // namespace

CsvRecords::CsvRecords(std::string_view text, char delimiter) : text_(text), delimiter_(delimiter) {}

void CsvRecords::skip_break() {
  if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
  ++at_;
  ++line_;
}

void CsvRecords::skip_line() {
  at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
  if (!at_end()) skip_break();
}

CsvRecords::End CsvRecords::read_quoted(std::string& out) {
  bool many_lines = false;
  for (++at_; !at_end() && at_ - begin_ < kMaxRecordBytes;) {
    if (at_break()) {
      many_lines = true;
      out += '\n';
      skip_break();
    } else if (text_[at_] != '"') {
      out += text_[at_++];
    } else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
      out += '"';
      at_ += 2;
    } else {
      ++at_;
      if (at_end() || at_break()) return End::kRecord;
      if (text_[at_] == delimiter_) return End::kField;
      if (many_lines) return End::kBroken;  // the end quote belongs to another line
      while (!at_end() && !at_break() && text_[at_] != delimiter_) out += text_[at_++];
      return at_end() || at_break() ? End::kRecord : End::kField;
    }
  }
  return End::kBroken;
}

CsvRecords::End CsvRecords::read_field(std::string& out) {
  if (at_end()) return End::kRecord;
  if (text_[at_] == '"') return read_quoted(out);
  while (!at_end() && !at_break() && text_[at_] != delimiter_) out += text_[at_++];
  return at_end() || at_break() ? End::kRecord : End::kField;
}

bool CsvRecords::next(CsvRecord& out) {
  out = {};
  if (at_end()) return false;
  out.line = line_;
  begin_ = at_;
  for (;;) {
    std::string field;
    const auto end = read_field(field);
    if (end == End::kBroken) {
      out.broken = true;
      at_ = begin_;
      line_ = out.line;
      skip_line();
      if (++broken_ > kMaxBroken && !at_end()) {
        gave_up_ = true;
        at_ = text_.size();
      }
      return true;
    }
    if (out.fields.size() < kMaxFields) {
      out.fields.push_back(std::move(field));
    } else {
      out.cut = true;
    }
    if (end == End::kRecord) break;
    ++at_;
  }
  if (!at_end()) skip_break();
  return true;
}

char delimiter_of(std::string_view text) {
  constexpr std::string_view kCandidates = "\t;,";
  std::array<std::size_t, kCandidates.size()> counts{};
  bool quoted = false;
  for (const char c : text.substr(0, 64UL * 1024)) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    const auto which = kCandidates.find(c);
    if (which != kCandidates.npos) ++counts[which];
    const bool any = std::any_of(counts.begin(), counts.end(), [](std::size_t count) { return count != 0; });
    if ((c == '\n' || c == '\r') && any) break;
  }
  const auto best = std::max_element(counts.begin(), counts.end());
  return *best == 0 ? '\0' : kCandidates[static_cast<std::size_t>(best - counts.begin())];
}

namespace {

enum class Column { kName, kAddress, kCentral, kUnfiltered, kDescription, kComment, kType, kSecurity };

struct Word {
  std::string_view text;  ///< in lower case
  Column column;
};

/// Words of headers. The English ones are those of ETS; the others are translations. A column without one of these
/// words is found by its place and content.
constexpr std::array kHeaderWords{
    Word{"group name", Column::kName},
    Word{"main", Column::kName},
    Word{"middle", Column::kName},
    Word{"sub", Column::kName},
    Word{"name", Column::kName},
    Word{"address", Column::kAddress},
    Word{"group address", Column::kAddress},
    Word{"adresse", Column::kAddress},
    Word{"gruppenadresse", Column::kAddress},
    Word{"adresse de groupe", Column::kAddress},
    Word{"indirizzo", Column::kAddress},
    Word{"dirección", Column::kAddress},
    Word{"adres", Column::kAddress},
    Word{"groepsadres", Column::kAddress},
    Word{"central", Column::kCentral},
    Word{"zentral", Column::kCentral},
    Word{"centrale", Column::kCentral},
    Word{"centraal", Column::kCentral},
    Word{"unfiltered", Column::kUnfiltered},
    Word{"ungefiltert", Column::kUnfiltered},
    Word{"non filtré", Column::kUnfiltered},
    Word{"non filtrato", Column::kUnfiltered},
    Word{"sin filtrar", Column::kUnfiltered},
    Word{"ongefilterd", Column::kUnfiltered},
    Word{"description", Column::kDescription},
    Word{"beschreibung", Column::kDescription},
    Word{"descrizione", Column::kDescription},
    Word{"descripción", Column::kDescription},
    Word{"beschrijving", Column::kDescription},
    Word{"omschrijving", Column::kDescription},
    Word{"comment", Column::kComment},
    Word{"kommentar", Column::kComment},
    Word{"commentaire", Column::kComment},
    Word{"commento", Column::kComment},
    Word{"comentario", Column::kComment},
    Word{"opmerking", Column::kComment},
    Word{"datapointtype", Column::kType},
    Word{"datapoint type", Column::kType},
    Word{"datenpunkttyp", Column::kType},
    Word{"datenpunkt typ", Column::kType},
    Word{"type de point de données", Column::kType},
    Word{"tipo di datapoint", Column::kType},
    Word{"tipo de datapoint", Column::kType},
    Word{"datapunttype", Column::kType},
    Word{"security", Column::kSecurity},
    Word{"sicherheit", Column::kSecurity},
    Word{"sécurité", Column::kSecurity},
    Word{"sicurezza", Column::kSecurity},
    Word{"seguridad", Column::kSecurity},
    Word{"beveiliging", Column::kSecurity},
};

std::optional<Column> column_of(std::string_view cell) {
  const auto small = to_lower(clean_text(cell, 64));
  for (const auto& word : kHeaderWords) {
    if (word.text == small) return word.column;
  }
  return {};
}

std::string_view cell(const CsvRecord& row, std::size_t column) {
  return column < row.fields.size() ? std::string_view(row.fields[column]) : std::string_view();
}

bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= 5 && text.find_first_not_of("0123456789") == text.npos;
}

bool has_slash_address(std::string_view text) {
  return looks_like_address(text) && text.find('/') != text.npos;
}

bool has_type(std::string_view text) {
  return text.starts_with("DPST-") || text.starts_with("DPT-");
}

std::size_t columns_of(std::span<const CsvRecord> rows) {
  std::size_t most = 0;
  for (const auto& row : rows) most = std::max(most, row.fields.size());
  return most;
}

template <class Test>
std::size_t count(std::span<const CsvRecord> rows, std::size_t column, Test test) {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [&](const CsvRecord& row) { return test(cell(row, column)); }));
}

/// The column with most cells that pass, if any; the last of several. Never the first column, which holds names.
template <class Test>
std::optional<std::size_t> best_column(std::span<const CsvRecord> rows, Test test) {
  std::optional<std::size_t> best;
  std::size_t most = 1;
  for (std::size_t column = 1; column < columns_of(rows); ++column) {
    const auto passing = count(rows, column, test);
    if (passing >= most) {
      most = passing;
      best = column;
    }
  }
  return best;
}

/// True for cells that are numbers, blank or `-`, with at least one number.
bool is_part_column(std::span<const CsvRecord> rows, std::size_t column) {
  const auto fits = [](std::string_view text) { return text.empty() || text == "-" || is_number(text); };
  return count(rows, column, is_number) != 0 && count(rows, column, fits) == rows.size();
}

/// Addresses without a slash: one column of numbers (free notation), or two or three adjacent ones.
bool find_number_columns(std::span<const CsvRecord> rows, CsvLayout& layout) {
  const auto columns = columns_of(rows);
  for (std::size_t column = 1; column < columns; ++column) {
    if (!is_part_column(rows, column) || count(rows, column, is_number) * 2 < rows.size()) continue;
    layout.address = column;
    layout.address_parts = 1;
    while (layout.address_parts < 3 && column + layout.address_parts < columns &&
           is_part_column(rows, column + layout.address_parts))
      ++layout.address_parts;
    return true;
  }
  return false;
}

bool find_address(std::span<const CsvRecord> rows, CsvLayout& layout) {
  const auto column = best_column(rows, has_slash_address);
  if (!column) return find_number_columns(rows, layout);
  layout.address = *column;
  return true;
}

/// The columns by the words of a header. The address column is found by content, if there is any.
struct Header {
  bool known = false;
  std::array<std::optional<std::size_t>, 8> columns{};
  std::optional<std::size_t> at(Column column) const { return columns[static_cast<std::size_t>(column)]; }
};

/// A header has two words of the table at least (a group may be called `Central`) and no address.
Header read_header(const CsvRecord& row) {
  Header header;
  std::size_t words = 0;
  for (std::size_t i = 0; i < row.fields.size(); ++i) {
    if (has_slash_address(row.fields[i])) return {};
    const auto column = column_of(row.fields[i]);
    if (!column) continue;
    ++words;
    header.columns[static_cast<std::size_t>(*column)] = i;
  }
  header.known = words >= 2;
  return header.known ? header : Header{};
}

/// The usual order of the columns after the address: central, unfiltered, description, [comment,] type, security.
void place_by_order(CsvLayout& layout, std::span<const CsvRecord> rows, std::size_t columns) {
  const auto behind = layout.address + layout.address_parts;
  const auto at = [&](std::size_t offset) {
    return behind + offset < columns ? std::optional(behind + offset) : std::nullopt;
  };
  layout.central = at(0);
  layout.unfiltered = at(1);
  layout.description = at(2);
  layout.type = best_column(rows, has_type);
  if (layout.type && *layout.type < behind + 3) layout.description = {};
  const bool has_comment = layout.type ? *layout.type > behind + 3 : columns > behind + 5;
  if (has_comment) layout.comment = at(3);
  if (!layout.type) layout.type = at(has_comment ? 4 : 3);
  if (layout.type && *layout.type + 1 < columns) layout.security = *layout.type + 1;
}

void place_by_words(CsvLayout& layout, const Header& header) {
  const auto prefer = [&](std::optional<std::size_t>& place, Column column) {
    if (header.at(column)) place = header.at(column);
  };
  prefer(layout.central, Column::kCentral);
  prefer(layout.unfiltered, Column::kUnfiltered);
  prefer(layout.description, Column::kDescription);
  prefer(layout.comment, Column::kComment);
  prefer(layout.type, Column::kType);
  prefer(layout.security, Column::kSecurity);
}

wire::Notation notation_of(std::span<const CsvRecord> rows, const CsvLayout& layout) {
  if (layout.address_parts == 2) return wire::Notation::kTwoLevel;
  if (layout.address_parts == 3) return wire::Notation::kThreeLevel;
  NotationDetector vote;
  for (const auto& row : rows) vote.add(cell(row, layout.address), true);
  return vote.winner();
}

}  // namespace

std::string CsvLayout::form() const {
  return fmt::format("ETS CSV {}/{}", names, address_parts);
}

std::optional<CsvLayout> find_layout(std::span<const CsvRecord> first_rows) {
  if (first_rows.empty()) return {};
  CsvLayout layout;
  const auto header = read_header(first_rows.front());
  const auto body = first_rows.subspan(1);
  const auto& first = first_rows.front();
  if (header.known) {
    layout.header = true;
    if (header.at(Column::kAddress)) {
      layout.address = *header.at(Column::kAddress);
    } else if (!find_address(body, layout)) {
      return {};
    }
  } else {
    // Without known words the first row is a header if it is the only one without an address.
    if (!find_address(body.empty() ? first_rows : body, layout)) return {};
    const auto text = cell(first, layout.address);
    layout.header = layout.address_parts == 1 ? !looks_like_address(text) : !text.empty() && !is_number(text);
  }
  if (layout.address == 0) return {};  // names always come first
  layout.names = std::min<std::size_t>(layout.address, 3);
  const auto rows = layout.header ? body : first_rows;
  place_by_order(layout, rows, std::max(columns_of(rows), first.fields.size()));
  place_by_words(layout, header);
  layout.notation = notation_of(rows, layout);
  return layout;
}

std::string address_text(const CsvRecord& row, const CsvLayout& layout) {
  if (layout.address_parts == 1) return clean_text(cell(row, layout.address), 64);
  std::string out;
  for (std::size_t i = 0; i < layout.address_parts; ++i) {
    auto part = clean_text(cell(row, layout.address + i), 64);
    out += fmt::format("{}{}", i == 0 ? "" : "/", part.empty() ? "-" : part);
  }
  return out;
}

}  // namespace rubicon::networks::knx::groups
