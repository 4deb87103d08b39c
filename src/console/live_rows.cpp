#include "console/live_rows.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "base/natural_order.h"

namespace rubicon::console {

namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return out;
}

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (text.empty()) return words;
    const auto word = text.substr(0, text.find(' '));
    words.push_back(lower(word));
    text.remove_prefix(word.size());
  }
}

/// The higher, the more urgent.
int trouble_of(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, int>, 9> kRanks{{{"network-down", 8},
                                                                    {"device-offline", 7},
                                                                    {"unreachable", 7},
                                                                    {"bad", 6},
                                                                    {"timed-out", 5},
                                                                    {"failed", 5},
                                                                    {"stale", 4},
                                                                    {"stored", 3},
                                                                    {"unknown", 2}}};
  const auto found =
      std::find_if(kRanks.begin(), kRanks.end(), [word](const auto& rank) { return rank.first == word; });
  return found == kRanks.end() ? 0 : found->second;
}

class Rows {
 public:
  Rows(const LiveSource& source, const LiveChoice& choice)
      : source_(source), choice_(choice), words_(words_of(choice.filter)) {}

  std::vector<LiveRow> by_network() {
    std::map<std::string, std::vector<std::string>> devices;
    for (auto& key : source_.devices()) {
      auto network = key.substr(0, key.rfind('.'));
      devices[network.substr(network.rfind('.') + 1)].push_back(std::move(key));
    }
    for (const auto& network : source_.networks()) {
      const auto at = rows_.size();
      const bool open = !words_.empty() || !choice_.folded.contains(network.id);
      for (const auto& key : open ? devices[network.id] : std::vector<std::string>()) add_device(key);
      if (rows_.size() > at || fits(network.id + " " + network.line + " " + network.reason))
        rows_.insert(rows_.begin() + static_cast<std::ptrdiff_t>(at), {LiveRow::Kind::kNetwork, network.id});
    }
    return std::move(rows_);
  }

  std::vector<LiveRow> sorted() {
    std::vector<Ranked> all;
    for (auto& key : source_.devices()) all.push_back(ranked(std::move(key)));
    std::stable_sort(all.begin(), all.end(), [](const Ranked& a, const Ranked& b) {
      if (a.rank != b.rank) return a.rank > b.rank;
      return base::natural_less(a.name, b.name);
    });
    for (const auto& one : all) add_device(one.key);
    return std::move(rows_);
  }

 private:
  struct Ranked {
    std::string key, name;
    std::int64_t rank = 0;
  };
  Ranked ranked(std::string key) const {
    const auto device = source_.device(key);
    Ranked one{std::move(key), lower(device.name.empty() ? device.id : device.name), 0};
    if (choice_.sort == LiveSort::kTrouble) one.rank = trouble_of(device.status);
    for (const auto& point : choice_.sort == LiveSort::kName ? std::vector<std::string>() : source_.points(one.key)) {
      const auto about = source_.point(point);
      if (choice_.sort == LiveSort::kLatest)
        one.rank = std::max<std::int64_t>(one.rank, about.heard.time_since_epoch().count());
      else
        one.rank = std::max<std::int64_t>({one.rank, trouble_of(about.quality), trouble_of(about.command)});
    }
    return one;
  }

  bool fits(const std::string& text) const {
    const auto where = lower(text);
    return std::all_of(words_.begin(), words_.end(),
                       [&](const std::string& word) { return where.find(word) != std::string::npos; });
  }

  void add_device(const std::string& key) {
    if (words_.empty()) {
      rows_.push_back({LiveRow::Kind::kDevice, key});
      if (choice_.folded.contains(key)) return;
      for (auto& point : source_.points(key)) rows_.push_back({LiveRow::Kind::kPoint, std::move(point)});
      return;
    }
    const auto device = source_.device(key);
    const auto about = key + " " + device.name + " " + device.status + " " + device.reason;
    const bool whole = fits(about);
    const auto at = rows_.size();
    for (auto& one : source_.points(key)) {
      const auto point = source_.point(one);
      if (whole || fits(about + " " + point.key + " " + point.value + " " + point.unit + " " + point.quality + " " +
                        point.command))
        rows_.push_back({LiveRow::Kind::kPoint, std::move(one)});
    }
    if (whole || rows_.size() > at)
      rows_.insert(rows_.begin() + static_cast<std::ptrdiff_t>(at), {LiveRow::Kind::kDevice, key});
  }

  const LiveSource& source_;
  const LiveChoice& choice_;
  const std::vector<std::string> words_;
  std::vector<LiveRow> rows_;
};

}  // namespace

std::string_view to_string(LiveSort sort) {
  switch (sort) {
    case LiveSort::kNetwork: return "network";
    case LiveSort::kName: return "name";
    case LiveSort::kLatest: return "latest";
    case LiveSort::kTrouble: return "trouble";
  }
  return "?";
}

std::vector<LiveRow> live_rows(const LiveSource& source, const LiveChoice& choice) {
  Rows rows(source, choice);
  return choice.sort == LiveSort::kNetwork ? rows.by_network() : rows.sorted();
}

}  // namespace rubicon::console
