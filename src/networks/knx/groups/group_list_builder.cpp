#include "networks/knx/groups/group_list_builder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

std::size_t slashes(std::string_view text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '/'));
}

std::string_view example(wire::Notation notation) {
  switch (notation) {
    case wire::Notation::kTwoLevel: return "two levels (1/519)";
    case wire::Notation::kFree: return "a plain number (2567)";
    case wire::Notation::kThreeLevel: break;
  }
  return "three levels (1/2/7)";
}

/// `01.02.2003`, `2003-02-01`, `1-Feb`: what a spreadsheet makes of 1/2/2003 or 1/2.
bool is_date(std::string_view text) {
  const auto is_mark = [](char c) { return c == '.' || c == '-' || c == '/'; };
  const auto marks = std::count_if(text.begin(), text.end(), is_mark);
  const auto begin = text.substr(0, std::min(text.find_first_of(".-/"), text.size()));
  const bool number = !begin.empty() && begin.find_first_not_of("0123456789") == begin.npos;
  return number && (marks == 2 || (marks == 1 && text.find_first_not_of("0123456789.-/") != text.npos));
}

constexpr std::string_view kDateHint =
    "; it looks like a date, which a spreadsheet makes of some addresses: export the list from ETS again, and let no "
    "spreadsheet save it";

std::size_t slashes_of(wire::Notation notation) {
  return notation == wire::Notation::kThreeLevel ? 2 : notation == wire::Notation::kTwoLevel ? 1 : 0;
}

}  // namespace

bool looks_like_address(std::string_view text) {
  if (text.empty() || text.size() > 32 || slashes(text) > 2) return false;
  bool part_begins = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '/') {
      if (part_begins) return false;
      part_begins = true;
      continue;
    }
    const bool dash = c == '-' && part_begins && (i + 1 == text.size() || text[i + 1] == '/');
    if (!dash && (c < '0' || c > '9')) return false;
    part_begins = false;
  }
  return !part_begins && text != "-";
}

void NotationDetector::add(std::string_view address, bool free_too) {
  if (!looks_like_address(address)) return;
  const auto count = slashes(address);
  if (count != 0 || free_too) ++votes_[count];
}

wire::Notation NotationDetector::winner() const {
  if (votes_[2] >= votes_[1] && votes_[2] >= votes_[0]) return wire::Notation::kThreeLevel;
  return votes_[1] >= votes_[0] ? wire::Notation::kTwoLevel : wire::Notation::kFree;
}

GroupListBuilder::GroupListBuilder(GroupList& list, wire::Notation notation) : list_(list), notation_(notation) {
  list_.report.notation = notation;
}

std::optional<wire::GroupAddress> GroupListBuilder::address(std::size_t line, std::string_view text) {
  auto& report = list_.report;
  if (looks_like_address(text) && slashes(text) != slashes_of(notation_)) {
    report.error(line, {}, fmt::format("wrong number of levels: '{}', expected {}", text, example(notation_)));
    return {};
  }
  const auto address = wire::parse_group(text);
  if (address) return *address;
  if (address.error().code == ErrorCode::kOutOfRange) ++report.out_of_range;
  const auto why = address.error().code == ErrorCode::kOutOfRange
                       ? address.error().text
                       : fmt::format("{} is not a group address, expected {}{}", model::quoted(text),
                                     example(notation_), is_date(text) ? kDateHint : "");
  report.error(line, {}, why);
  return {};
}

std::optional<wire::GroupAddress> GroupListBuilder::address_of_number(std::size_t line, std::string_view text) {
  const auto value = base::parse_number<std::uint64_t>(text);
  if (value && *value >= 1 && *value <= 0xffff) return wire::GroupAddress(*value);
  if (value) ++list_.report.out_of_range;
  list_.report.error(line, {},
                     fmt::format("its address is {}, expected a number from 1 to 65535", model::quoted(text)));
  return {};
}

std::optional<dpt::DptId> GroupListBuilder::type(std::string_view text, std::vector<std::string>& changes) const {
  constexpr std::string_view kBreaks = " ,;\t\n";
  const auto begin = std::min(text.find_first_not_of(kBreaks), text.size());
  const auto end = std::min(text.find_first_of(kBreaks, begin), text.size());
  if (begin == end) return {};
  const auto first = text.substr(begin, end - begin);
  if (text.find_first_not_of(kBreaks, end) != text.npos)
    changes.push_back(fmt::format("several types, the first is used: {}", model::quoted(text)));
  const auto id = dpt::parse_dpt(first);
  if (!id) {
    changes.push_back(fmt::format("type {} is not a data point type: imported without a type", model::quoted(first)));
    return {};
  }
  const auto* type = dpt::find_dpt(*id);
  if (!type) {
    changes.push_back(fmt::format("main type {} unknown: imported without a type, values shown as hex", id->main));
    return {};
  }
  if (id->sub != dpt::DptId::kMainOnly && type->id.sub == dpt::DptId::kMainOnly) {
    changes.push_back(fmt::format("sub type of {} unknown: imported with main type {}", to_string(*id), id->main));
    return type->id;
  }
  return *id;
}

std::string GroupListBuilder::field(std::string_view what, std::string_view utf8,
                                    std::vector<std::string>& changes) const {
  if (utf8.size() > kMaxFieldBytes)
    changes.push_back(fmt::format("its {} has more than {} bytes: cut", what, kMaxFieldBytes));
  return clean_text(utf8, kMaxFieldBytes);
}

bool GroupListBuilder::full(std::size_t line) {
  if (list_.entries.size() < kMaxGroupAddresses) return false;
  list_.report.error(line, {}, fmt::format("more than {} group addresses: the rest is left out", kMaxGroupAddresses));
  return true;
}

void GroupListBuilder::add(GroupEntry entry, const std::vector<std::string>& changes) {
  auto& report = list_.report;
  const auto [first, is_new] = lines_.try_emplace(number(entry.address), entry.line);
  if (!is_new) {
    ++report.doubled;
    report.error(entry.line, entry.address,
                 fmt::format("duplicate address, the first one is kept (line {})", first->second));
    return;
  }
  entry.notation = notation_;
  const auto security = to_lower(entry.security);
  entry.secured = security == "on" || (entry.secured && security != "off");
  auto all = changes;
  if (entry.name.empty()) {
    entry.name = to_string(entry.address, notation_);
    all.push_back("empty name: imported, its name is the address");
  }
  if (!entry.dpt) ++report.untyped;
  if (entry.secured) ++report.secured;
  if (entry.dpt && entry.dpt->sub == dpt::DptId::kMainOnly) ++report.main_type_only;
  if (!all.empty()) {
    report.warning(entry.line, entry.address, joined(all));
  } else if (!entry.dpt) {
    report.note(entry.line, entry.address, "no type: its values are shown as hex");
  }
  ++report.taken;
  list_.entries.push_back(std::move(entry));
}

std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, "; "));
}

}  // namespace rubicon::networks::knx::groups
