#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "base/text.h"
#include "networks/knx/groups/csv_layout.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_list_builder.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

/// Number of rows from which the layout is found.
constexpr std::size_t kFirstRows = 500;

/// Converts a row to UTF-8. True if the row was not UTF-8 in a file that is.
bool decode(CsvRecord& row, Encoding encoding) {
  if (encoding == Encoding::kUtf8) return false;
  const bool good =
      std::all_of(row.fields.begin(), row.fields.end(), [](const auto& field) { return base::is_utf8(field); });
  if (encoding == Encoding::kMixed && good) return false;
  for (auto& field : row.fields) field = from_windows_1252(field);
  return encoding == Encoding::kMixed;
}

bool is_blank(const CsvRecord& row) {
  return std::all_of(row.fields.begin(), row.fields.end(),
                     [](const auto& field) { return field.find_first_not_of(" \t\n") == field.npos; });
}

bool is_true(std::string_view text) {
  const auto small = to_lower(text);
  return small == "true" || small == "1" || small == "yes" || small == "x" || small == "wahr" || small == "vrai";
}

/// Names of main and middle groups, from the range rows before an address.
class RangeNames {
 public:
  /// `1/-/-`, `1/0/-`: the names of that range.
  void set(std::string_view address, std::string_view main, std::string_view middle) {
    const auto key = address.substr(0, address.find("/-"));
    if (key.empty() || key == "-") {
      if (!main.empty()) last_main_ = main, last_middle_.clear();
      if (!middle.empty()) last_middle_ = middle;
      return;
    }
    if (names_.size() > 4096) return;  // a project has fewer
    names_.insert_or_assign(std::string(key), std::string(middle.empty() ? main : middle));
  }

  void apply(GroupEntry& entry) const {
    const auto value = number(entry.address);
    const auto main = entry.notation == wire::Notation::kFree ? std::string("-") : fmt::format("{}", value >> 11);
    entry.main_group = find(main, last_main_);
    entry.middle_group = entry.notation == wire::Notation::kThreeLevel
                             ? find(fmt::format("{}/{}", main, value >> 8 & 7), last_middle_)
                             : last_middle_;
  }

 private:
  std::string find(const std::string& key, const std::string& otherwise) const {
    const auto found = names_.find(key);
    return found == names_.end() ? otherwise : found->second;
  }

  std::unordered_map<std::string, std::string> names_;
  std::string last_main_, last_middle_;  ///< of ranges without an address
};

class CsvList {
 public:
  CsvList(GroupList& list, const CsvLayout& layout) : list_(list), layout_(layout), builder_(list, layout.notation) {}

  void take(const CsvRecord& row, bool was_not_utf8) {
    std::vector<std::string> changes;
    if (was_not_utf8) changes.emplace_back("not UTF-8: its bytes are read as Windows-1252");
    if (row.cut) changes.emplace_back("more than 64 columns: the others are left out");
    const auto text = address_text(row, layout_);
    const auto main = name(row, 0, changes), middle = name(row, 1, changes);
    if (is_range(row, text)) return take_range(row, text, main, middle);
    if (row.fields.size() <= layout_.address) {
      return list_.report.error(row.line, {}, "columns missing: the row has no address");
    }
    const auto address = builder_.address(row.line, text);
    if (!address) return;
    GroupEntry entry;
    entry.line = row.line;
    entry.address = *address;
    entry.notation = builder_.notation();
    names_.apply(entry);
    if (!main.empty()) entry.main_group = main;
    if (!middle.empty()) entry.middle_group = middle;
    fill(row, entry, changes);
    builder_.add(std::move(entry), changes);
  }

  bool full(std::size_t line) { return builder_.full(line); }

 private:
  std::string_view text(const CsvRecord& row, std::optional<std::size_t> column) const {
    return column && *column < row.fields.size() ? std::string_view(row.fields[*column]) : std::string_view();
  }

  /// From the columns of the main and middle group, if the layout has them.
  std::string name(const CsvRecord& row, std::size_t level, std::vector<std::string>& changes) const {
    if (level + 1 >= layout_.names) return {};
    return builder_.field("group name", text(row, level), changes);
  }

  /// True for a row that names a range: `1/-/-`, or no address and only the name of a group.
  bool is_range(const CsvRecord& row, const std::string& address) const {
    if (looks_like_address(address) && address.ends_with("/-")) return true;
    const bool none = address.empty() || address.find_first_not_of("-/") == address.npos;
    if (!none || row.fields.size() <= layout_.address) return false;
    if (layout_.names == 1) return builder_.notation() == wire::Notation::kFree;
    return clean_text(text(row, layout_.names - 1), 8).empty();
  }

  void take_range(const CsvRecord& row, const std::string& address, std::string main, std::string middle) {
    if (layout_.names == 1) {
      std::vector<std::string> changes;
      auto only = builder_.field("group name", text(row, 0), changes);
      const bool is_middle = builder_.notation() == wire::Notation::kThreeLevel && !address.ends_with("/-/-");
      (is_middle ? middle : main) = std::move(only);
    }
    names_.set(address, main, middle);
  }

  void fill(const CsvRecord& row, GroupEntry& entry, std::vector<std::string>& changes) const {
    entry.name = builder_.field("name", text(row, layout_.names - 1), changes);
    entry.central = is_true(text(row, layout_.central));
    entry.unfiltered = is_true(text(row, layout_.unfiltered));
    auto description = text(row, layout_.description);
    if (description.empty()) description = text(row, layout_.comment);
    entry.description = builder_.field("description", description, changes);
    const auto security = clean_text(text(row, layout_.security), 16);
    if (!security.empty()) entry.security = security;
    if (!layout_.type) return;
    if (*layout_.type < row.fields.size()) {
      entry.dpt = builder_.type(text(row, layout_.type), changes);
    } else {
      changes.emplace_back("columns missing: imported without a type");
    }
  }

  GroupList& list_;
  CsvLayout layout_;
  GroupListBuilder builder_;
  RangeNames names_;
};

std::vector<CsvRecord> first_rows(std::string_view text, char delimiter, Encoding encoding) {
  std::vector<CsvRecord> rows;
  CsvRecords records(text, delimiter);
  for (CsvRecord row; rows.size() < kFirstRows && records.next(row);) {
    decode(row, encoding);
    if (!row.broken && !is_blank(row)) rows.push_back(std::move(row));
  }
  return rows;
}

void read_rows(CsvRecords& records, Encoding encoding, CsvList& list, bool header, Report& report) {
  for (CsvRecord row; records.next(row);) {
    const bool was_not_utf8 = decode(row, encoding);
    if (row.broken) {
      report.error(row.line, {}, "quote never closed: the line is not imported");
      continue;
    }
    if (is_blank(row)) continue;
    if (header) {
      header = false;
      continue;
    }
    if (list.full(row.line)) return;
    list.take(row, was_not_utf8);
  }
  if (records.gave_up())
    report.error(0, {}, "more than 1000 quotes never closed: the rest of the file is not imported");
}

}  // namespace

GroupList read_csv(std::string_view text) {
  GroupList list;
  list.report.form = "ETS CSV";
  const auto encoding = encoding_of(text);
  if (text.starts_with(kUtf8Mark)) text.remove_prefix(kUtf8Mark.size());
  const auto delimiter = delimiter_of(text);
  if (delimiter == '\0') {
    list.report.refuse(
        1, "no tab, semicolon or comma in the file, expected an ETS export of group addresses: file refused");
    return list;
  }
  const auto layout = find_layout(first_rows(text, delimiter, encoding));
  if (!layout) {
    list.report.refuse(1, "no address column in the header or below: file refused, nothing imported");
    return list;
  }
  list.report.form = layout->form();
  CsvList rows(list, *layout);
  CsvRecords records(text, delimiter);
  read_rows(records, encoding, rows, layout->header, list.report);
  if (list.entries.empty()) list.report.warning(0, {}, "the file has no group address");
  return list;
}

}  // namespace rubicon::networks::knx::groups
