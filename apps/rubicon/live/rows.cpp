#include "apps/rubicon/live/rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "apps/rubicon/output/tuple_text.h"
#include "base/compare_text.h"
#include "base/text.h"
#include "model/point_keys.h"
#include "rubicon/key.hpp"
#include "rubicon/summary.hpp"
#include "rubicon/unit.hpp"

namespace rubicon::cli::live {

namespace {

std::string part_of(std::string_view key, std::size_t index) {
  const auto parts = model::key_parts(key);
  return index < parts.size() ? std::string(parts[index]) : std::string();
}

}  // namespace

LiveSource::LiveSource(const TupleSpace& space, std::optional<OwnerId> island, std::string prefix)
    : space_(space), island_(island), prefix_(std::move(prefix)) {}

std::optional<tuples::TupleView> LiveSource::tuple(std::string_view name) const {
  const auto colon = name.find(':');
  const auto owner = base::parse_number<std::uint32_t>(name.substr(0, colon));
  return owner ? space_.get(OwnerId(*owner), name.substr(colon + 1)) : std::nullopt;
}

std::string LiveSource::value(const std::string& name) const {
  const auto found = tuple(name);
  return found ? std::string(found->value) : std::string();
}

const std::vector<LiveIsland>& LiveSource::look() {
  islands_.clear();
  space_.list({island_, model::IslandKey{prefix_}.networks()}, [&](const tuples::TupleView& tuple) {
    const auto summary = model::summary_from_json(space_.summary(tuple.owner));
    islands_.push_back({tuple.owner, summary ? summary->name : std::string(), tuple.owner_present});
  });
  std::sort(islands_.begin(), islands_.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  learn_names();
  return islands_;
}

/// Again only where one changed: this is done for every frame.
void LiveSource::learn_names() {
  std::map<OwnerId, std::string> now;
  const auto key = prefix_ + ".overview";
  space_.list({island_, key}, [&](const tuples::TupleView& tuple) { now[tuple.owner] = tuple.value; });
  if (now == overviews_) return;
  names_.points.clear();
  for (const auto& [island, overview] : now) client::add_point_names(island, key, overview, names_);
  overviews_ = std::move(now);
}

std::vector<std::string> LiveSource::networks() const {
  std::vector<std::string> keys;
  space_.list({island_, model::IslandKey{prefix_}.network("*").status()}, [&](const tuples::TupleView& tuple) {
    if (!model::is_of_island(tuple.key)) keys.push_back(name_of(tuple.owner, model::parent_key(tuple.key)));
  });
  std::sort(keys.begin(), keys.end(), base::natural_less);
  return keys;
}

std::string LiveSource::network_name(const std::string& key) const {
  const auto island = islands_.size() > 1 ? key.substr(0, key.find(':') + 1) : std::string();
  return island + part_of(key, 1);
}

LiveNetwork LiveSource::network(const std::string& key) const {
  const auto found = tuple(model::NetworkKey{key}.status());
  if (found && !found->owner_present) return {network_name(key), "absent", "the island left, or does not answer"};
  auto status = found ? model::line_status_from_json(found->value) : LineStatus{};
  return {network_name(key), std::move(status.line), std::move(status.reason)};
}

std::vector<std::string> LiveSource::devices() const {
  std::vector<std::string> keys;
  const auto any = model::IslandKey{prefix_}.network("*").device("*");
  space_.list({island_, any.status()}, [&](const tuples::TupleView& tuple) {
    if (!model::is_of_island(tuple.key)) keys.push_back(name_of(tuple.owner, model::parent_key(tuple.key)));
  });
  std::sort(keys.begin(), keys.end(), base::natural_less);
  return keys;
}

LiveDevice LiveSource::device(const std::string& key) const {
  const model::DeviceKey device{key};
  auto condition = model::device_condition_from_json(value(device.status()));
  auto description = model::device_description_from_json(value(device.description()));
  return {network_name(key), part_of(key, 2), description ? std::move(description->name) : std::string(),
          std::move(condition.status), std::move(condition.reason)};
}

std::vector<std::string> LiveSource::points(const std::string& device) const {
  std::vector<std::string> keys;
  const auto colon = device.find(':');
  const auto owner = base::parse_number<std::uint32_t>(std::string_view(device).substr(0, colon));
  for (const auto* kind : {"sensor", "actuator"}) {
    const auto begin = static_cast<std::ptrdiff_t>(keys.size());
    space_.list(
        {OwnerId(owner.value_or(0)), model::DeviceKey{device.substr(colon + 1)}.point(kind, "*").value()},
        [&](const tuples::TupleView& tuple) { keys.push_back(name_of(tuple.owner, model::parent_key(tuple.key))); });
    std::sort(keys.begin() + begin, keys.end(), base::natural_less);
  }
  return keys;
}

model::PointDescription LiveSource::description(const std::string& point) const {
  return model::point_description_from_json(value(model::PointKey{point}.description()))
      .value_or(model::PointDescription{});
}

LivePoint LiveSource::point(const std::string& key) const {
  const model::PointKey point{key};
  const auto shown = tuple(point.value());
  auto status = model::point_status_from_json(value(point.status()));
  if (shown && !shown->owner_present) status.quality = to_string(Quality::kNetworkDown);
  const auto rate = per_second_.find(point.value());
  return {part_of(key, 4),
          shown ? std::string(shown->value) : std::string(),
          model::unit_text(description(key).unit),
          std::move(status.quality),
          std::move(status.command),
          status.heard,
          rate == per_second_.end() ? 0 : rate->second,
          client::name_of_point(names_, shown ? shown->owner : OwnerId(), key.substr(key.find(':') + 1))};
}

LiveSource::Count LiveSource::count() const {
  Count count;
  const auto any = model::IslandKey{prefix_}.network("*").device("*");
  space_.list({island_, any.status()}, [&](const tuples::TupleView& tuple) {
    if (model::is_of_island(tuple.key)) return;
    ++count.devices;
    if (tuple.owner_present && model::says_reachable(tuple.value)) ++count.reachable;
  });
  return count;
}

std::string LiveSource::short_name(const std::string& point) const {
  return fmt::format("{}.{}.{}", network_name(point), part_of(point, 2), part_of(point, 4));
}

std::string LiveSource::command_to_try() const {
  std::string first;
  const auto any = model::IslandKey{prefix_}.network("*").device("*").point(Kind::kActuator, "*");
  space_.list({island_, any.command()}, [&](const tuples::TupleView& tuple) {
    auto point = name_of(tuple.owner, model::parent_key(tuple.key));
    if (!first.empty() && point > first) return;
    if (tuple.owner_present && description(point).data_type == "boolean") first = std::move(point);
  });
  if (first.empty()) return "islands";
  const auto words = description(first).words;
  const bool has_words = words.size() == 2;
  const std::string off = has_words ? words[0].text : "off", on = has_words ? words[1].text : "on";
  return fmt::format("set {} {}", short_name(first), value(model::PointKey{first}.value()) == on ? off : on);
}

void LiveSource::count(OwnerId owner, std::string_view key, WallTime when) {
  rates_.count(name_of(owner, key), when);
}

void LiveSource::end_round(Duration length) {
  per_second_.clear();
  for (auto& row : rates_.round(length)) per_second_.emplace(std::move(row.name), row.per_second);
}

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
    for (auto& key : source_.devices()) devices[key.substr(0, key.rfind('.'))].push_back(std::move(key));
    for (auto& network : source_.networks()) {
      const auto at = rows_.size();
      const bool open = !words_.empty() || !choice_.folded.contains(network);
      for (const auto& key : open ? devices[network] : std::vector<std::string>()) add_device(key);
      const auto about = source_.network(network);
      if (rows_.size() > at || fits(about.name + " " + about.line + " " + about.reason))
        rows_.insert(rows_.begin() + static_cast<std::ptrdiff_t>(at), {LiveRow::Kind::kNetwork, std::move(network)});
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
      else if (choice_.sort == LiveSort::kBusiest)
        one.rank = std::max(one.rank, static_cast<std::int64_t>(about.per_second * 1000));
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
    const auto about =
        key + " " + device.network + "." + device.id + " " + device.name + " " + device.status + " " + device.reason;
    const bool whole = fits(about);
    const auto at = rows_.size();
    for (auto& one : source_.points(key)) {
      const auto point = source_.point(one);
      if (whole || fits(about + " " + one + " " + point.name + " " + point.value + " " + point.unit + " " +
                        point.quality + " " + point.command))
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
    case LiveSort::kBusiest: return "busiest";
    case LiveSort::kTrouble: return "trouble";
  }
  return "?";
}

std::vector<LiveRow> live_rows(const LiveSource& source, const LiveChoice& choice) {
  Rows rows(source, choice);
  return choice.sort == LiveSort::kNetwork ? rows.by_network() : rows.sorted();
}

}  // namespace rubicon::cli::live
