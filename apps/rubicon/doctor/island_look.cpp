#include "apps/rubicon/doctor/island_look.h"

#include <algorithm>
#include <utility>

#include "base/scheduler.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

/// Counters are published once a second: what was lost before is in them after this.
constexpr Duration kPublication = std::chrono::milliseconds(1100);

void pass(Client& client, Duration time) {
  client.run_until([] { return false; }, time);
}

}  // namespace

/// Islands say what their clocks say while a component asks (docs/tuple-keys.md).
IslandLook::IslandLook(Client& client, Duration patience) : client_(client), patience_(patience) {
  clocks_ = client.tuples().subscribe(
      {std::nullopt, model::IslandKey{"*"}.property("clock")}, {}, [this](const Event& event) {
        if (event.kind == EventKind::kSet && !event.tuple.value.empty())
          clock_offsets_[event.tuple.owner] = event.tuple.write_time - std::chrono::system_clock::now();
      });
}

void IslandLook::first() {
  client_.discover();
  pass(client_, kPublication);
  for (auto& island : client_.islands()) all_.push_back(seen_first(std::move(island)));
}

std::vector<IslandSeen> IslandLook::second() {
  add_newcomers();
  for (auto& seen : all_) look_again(seen);
  return std::move(all_);
}

void IslandLook::add_newcomers() {
  client_.discover();
  for (auto& island : client_.islands()) {
    const auto is_it = [&](const IslandSeen& seen) { return seen.island.id == island.id; };
    if (std::none_of(all_.begin(), all_.end(), is_it)) all_.emplace_back().island = std::move(island);
  }
}

/// A read that timed out returns only what arrived in time.
IslandSeen IslandLook::seen_first(client::Component island) {
  const auto start = client_.scheduler().now();
  IslandSeen seen;
  seen.before = client_.networks(island.id, patience_);
  seen.numbers_before = counters_of(properties_of(island.id));
  seen.known_before = client_.scheduler().now() - start < patience_ && !seen.numbers_before.empty();
  seen.island = std::move(island);
  return seen;
}

void IslandLook::look_again(IslandSeen& seen) {
  const auto id = seen.island.id;
  seen.answers = !client_.read({id, model::IslandKey{"*"}.island()}, patience_).empty();
  seen.now = client_.networks(id, patience_);
  seen.properties = properties_of(id);
  seen.numbers = counters_of(seen.properties);
  const auto history = client_.read({id, model::IslandKey{"*"}.history().status()}, patience_);
  if (!history.empty()) seen.history = history.front().value;
  for (const auto& status : client_.read({id, model::IslandKey{"*"}.bridge("*").status()}, patience_))
    seen.bridges[std::string(model::last_part(model::parent_key(status.key)))] = status.value;
  const auto alerts = client_.read({id, model::IslandKey{"*"}.alerts()}, patience_);
  if (!alerts.empty()) seen.alerts = model::alerts_from_json(alerts.front().value);
  if (const auto offset = clock_offsets_.find(id); offset != clock_offsets_.end()) seen.clock_offset = offset->second;
}

IslandLook::Properties IslandLook::properties_of(OwnerId island) {
  Properties properties;
  for (const auto& tuple : client_.read({island, model::IslandKey{"*"}.property("*")}, patience_))
    properties[std::string(model::key_parts(tuple.key)[2])] = tuple.value;
  return properties;
}

std::vector<IslandSeen> look_at_islands(Client& client, Duration between, Duration patience) {
  IslandLook look(client, patience);
  look.first();
  pass(client, between);
  return look.second();
}

}  // namespace rubicon::cli
