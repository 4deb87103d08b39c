#include "apps/rubicon/rates.h"

#include <algorithm>

namespace rubicon::cli {

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

}  // namespace rubicon::cli
