#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_list_builder.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

/// Main types of the EIS numbers 1 to 15 (KNX 3/7/2, predecessors of the data point types). 10, 11 and 14 are
/// signed or unsigned: the unsigned type is used.
constexpr std::array<std::uint16_t, 16> kMainOfEis{0, 1, 3, 10, 11, 9, 5, 1, 2, 14, 7, 12, 15, 4, 5, 16};

std::vector<std::string_view> split(std::string_view line, char at) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto cut = std::min(line.find(at), line.size());
    parts.push_back(line.substr(0, cut));
    if (cut == line.size() || parts.size() >= 4096) return parts;
    line.remove_prefix(cut + 1);
  }
}

std::optional<unsigned> number_at(std::string_view text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end == text.data()) return {};
  return value;
}

/// `(2 Byte)`, `(1 Bit)` at the end of a type; 0 = unknown.
std::uint8_t size_of(std::string_view type) {
  const auto open = type.rfind('(');
  if (open == type.npos) return 0;
  const auto count = number_at(type.substr(open + 1));
  if (!count || *count > 31) return 0;
  const auto bits = type.find("Byte", open) != type.npos || type.find("Octet", open) != type.npos ? *count * 8 : *count;
  return static_cast<std::uint8_t>(bits);
}

std::string size_text(std::uint8_t bits) {
  return bits == 0 ? std::string("of unknown size") : fmt::format("size {} bit only", bits);
}

void read_type(std::string_view text, GroupEntry& entry, std::vector<std::string>& changes) {
  entry.size_bits = size_of(text);
  const auto eis = text.starts_with("EIS ") ? number_at(text.substr(4)) : std::nullopt;
  if (eis && *eis >= 1 && *eis < kMainOfEis.size()) {
    entry.dpt = dpt::DptId{kMainOfEis[*eis], dpt::DptId::kMainOnly};
    if (*eis == 10 || *eis == 11 || *eis == 14)
      changes.push_back(
          fmt::format("EIS {} does not tell its sign: imported with main type {}", *eis, entry.dpt->main));
  } else if (text.starts_with("Uncertain")) {
    changes.push_back(fmt::format("type uncertain: {}", size_text(entry.size_bits)));
  } else {
    changes.push_back(
        fmt::format("type {} unknown: imported with {}", model::quoted(text), size_text(entry.size_bits)));
  }
}

bool known_priority(std::string_view text) {
  static constexpr std::array<std::string_view, 12> kWords{"low",  "normal",  "high", "urgent", "alarm", "system",
                                                           "auto", "niedrig", "hoch", "bas",    "haut",  ""};
  const auto small = to_lower(text);
  return std::find(kWords.begin(), kWords.end(), small) != kWords.end();
}

class EsfList {
 public:
  EsfList(GroupList& list, wire::Notation notation) : list_(list), builder_(list, notation) {}

  bool full(std::size_t line) { return builder_.full(line); }

  void take(std::size_t line, std::string_view text) {
    const auto columns = split(text, '\t');
    if (columns.size() < 3) {
      return list_.report.error(line, {}, "columns missing, expected address, name and type, separated by tabs");
    }
    const auto dot = columns[0].rfind('.');
    const auto address_text = dot == text.npos ? columns[0] : columns[0].substr(dot + 1);
    if (!looks_like_address(address_text)) {
      return list_.report.error(line, {},
                                fmt::format("no address after the last dot of {}", model::quoted(columns[0])));
    }
    const auto address = builder_.address(line, address_text);
    if (!address) return;
    std::vector<std::string> changes;
    GroupEntry entry;
    entry.line = line;
    entry.address = *address;
    fill_groups(dot == text.npos ? std::string_view() : columns[0].substr(0, dot), entry, changes);
    entry.name = builder_.field("name", columns[1], changes);
    if (columns.size() > 3 && !known_priority(columns[3])) changes.emplace_back("priority unknown: low assumed");
    read_type(columns[2], entry, changes);
    if (columns.size() > 4) fill_listen(columns[4], entry, changes);
    builder_.add(std::move(entry), changes);
  }

 private:
  /// Group names may contain dots: the first dot ends the main group.
  void fill_groups(std::string_view groups, GroupEntry& entry, std::vector<std::string>& changes) const {
    const auto dot = std::min(groups.find('.'), groups.size());
    const bool has_middle = builder_.notation() == wire::Notation::kThreeLevel && dot < groups.size();
    entry.main_group = builder_.field("group name", has_middle ? groups.substr(0, dot) : groups, changes);
    if (has_middle) entry.middle_group = builder_.field("group name", groups.substr(dot + 1), changes);
  }

  void fill_listen(std::string_view text, GroupEntry& entry, std::vector<std::string>& changes) const {
    for (const auto part : split(text, ' ')) {
      if (part.empty()) continue;
      const auto address = wire::parse_group(part);
      if (!address) {
        changes.push_back(fmt::format("listening address {} ignored", model::quoted(part)));
        if (changes.size() > 16) return;
      } else if (std::find(entry.listen.begin(), entry.listen.end(), *address) == entry.listen.end()) {
        entry.listen.push_back(*address);
      }
    }
  }

  GroupList& list_;
  GroupListBuilder builder_;
};

struct Line {
  std::size_t number;
  std::string_view text;
};

/// Calls `take` with each line after the first, which is the name of the project, until it returns false.
template <class Take>
void each_line(std::string_view text, Take take) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    auto line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (number > 1 && !take(Line{number, line})) return;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

wire::Notation esf_notation(std::string_view text) {
  NotationDetector vote;
  each_line(text, [&](const Line& line) {
    const auto first = line.text.substr(0, line.text.find('\t'));
    vote.add(first.substr(first.rfind('.') + 1), true);
    return line.number < 1000;
  });
  return vote.winner();
}

}  // namespace

GroupList read_esf(std::string_view text) {
  GroupList list;
  list.report.form = "ESF";
  const auto encoding = encoding_of(text);
  if (text.starts_with(kUtf8Mark)) text.remove_prefix(kUtf8Mark.size());
  EsfList lines(list, esf_notation(text));
  each_line(text, [&](const Line& line) {
    if (line.text.find_first_not_of(" \t") == line.text.npos) return true;
    if (lines.full(line.number)) return false;
    const bool decode =
        encoding == Encoding::kWindows1252 || (encoding == Encoding::kMixed && !base::is_utf8(line.text));
    lines.take(line.number, decode ? from_windows_1252(line.text) : std::string(line.text));
    return true;
  });
  if (list.entries.empty()) list.report.warning(0, {}, "the file has no group address");
  return list;
}

}  // namespace rubicon::networks::knx::groups
