#include "apps/rubicon/doctor/signs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/rubicon/doctor/secure_findings.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::cli {

bool counts_loss(std::string_view name) {
  if (is_secure_counter(name)) return true;
  if (name == "dds-refused-peers") return false;  // strangers; check_island_trust() has them
  constexpr std::array<std::string_view, 22> kWords{
      "dropped",     "lost",     "refused", "undeliverable", "undelivered", "undecodable", "malformed",  "looped",
      "damaged",     "failures", "failed",  "bad",           "cut",         "missing",     "undeclared", "unknown",
      "unconfirmed", "expired",  "skipped", "not",           "forged",      "implausible"};
  while (!name.empty()) {
    const auto word = name.substr(0, name.find('-'));
    if (std::find(kWords.begin(), kWords.end(), word) != kWords.end()) return true;
    name.remove_prefix(std::min(name.size(), word.size() + 1));
  }
  return false;
}

Counters counters_of(const std::map<std::string, std::string>& properties) {
  Counters counters;
  for (const auto& [name, text] : properties) {
    if (const auto number = base::parse_number<std::uint64_t>(text)) counters[name] = *number;
  }
  return counters;
}

Counters losses_of(const Counters& counters) {
  Counters losses;
  for (const auto& [name, count] : counters) {
    if (count > 0 && counts_loss(name)) losses[name] = count;
  }
  return losses;
}

Counters growth_of(const Counters& before, const Counters& now) {
  Counters growth;
  for (const auto& [name, count] : now) {
    const auto known = before.find(name);
    const auto start = known == before.end() || known->second > count ? 0 : known->second;
    if (count > start) growth[name] = count - start;
  }
  return growth;
}

std::string losses_text(const Counters& losses, const Counters& growth) {
  std::string text;
  for (const auto& [name, count] : losses) {
    const auto grown = growth.find(name);
    text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", name, count,
                        grown == growth.end() ? "" : fmt::format(" (+{})", grown->second));
  }
  return text;
}

void Rates::count(const std::string& name, WallTime when) {
  auto& entry = entries_[name];
  ++entry.total;
  ++entry.now;
  entry.last = std::max(entry.last, when);
}

std::vector<Rates::Row> Rates::round(Duration length) {
  const auto seconds = std::max(1e-9, std::chrono::duration<double>(length).count());
  std::vector<Row> rows;
  rows.reserve(entries_.size());
  for (auto& [name, entry] : entries_) {
    rows.push_back({name, static_cast<double>(entry.now) / seconds, entry.total, entry.last});
    entry.now = 0;
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& one, const Row& other) { return one.per_second > other.per_second; });
  return rows;
}

std::string group_of(std::string_view name, std::string_view by) {
  const int dots = by == "device" ? 3 : by == "network" ? 2 : 0;
  if (by == "island") return std::string(name.substr(0, name.find(':')));
  std::size_t end = 0;
  for (int i = 0; i < dots; ++i) {
    end = name.find('.', end);
    if (end == name.npos) return std::string(name);
    ++end;
  }
  return std::string(dots == 0 ? name : name.substr(0, end - 1));
}

std::vector<LogLine> log_lines_in(const tuples::TupleView& tuple) {
  std::vector<LogLine> lines;
  const auto list = model::parse_json(tuple.value);
  if (!list.is_array()) return lines;
  for (const auto& one : list) {
    lines.push_back({tuple.owner, model::count_of(one, "number"), model::time_of(one, "time"),
                     model::text_of(one, "level"), model::text_of(one, "subject"), model::text_of(one, "text")});
  }
  return lines;
}

NewLines::News NewLines::take(const tuples::TupleView& tuple) {
  News news{log_lines_in(tuple)};
  if (news.lines.empty()) return news;
  auto& last = last_[tuple.owner];
  if (news.lines.back().number < last) last = 0;  // the island was started again
  if (last > 0 && news.lines.front().number > last + 1) news.missed = news.lines.front().number - last - 1;
  std::erase_if(news.lines, [&](const LogLine& line) { return line.number <= last; });
  if (!news.lines.empty()) last = news.lines.back().number;
  return news;
}

}  // namespace rubicon::cli
