#include "apps/rubicon/island_look.h"

#include <map>

namespace rubicon::cli {

namespace {

std::map<std::string, std::string> properties_of(Client& client, OwnerId island, Duration patience) {
  std::map<std::string, std::string> properties;
  for (const auto& tuple : client.read({island, "*.property.*.value"}, patience))
    properties[std::string(model::key_parts(tuple.key)[2])] = tuple.value;
  return properties;
}

/// Islands say what their clocks say while a component asks (docs/tuple-keys.md).
class Clocks {
 public:
  explicit Clocks(Client& client) {
    handle_ = client.tuples().subscribe({std::nullopt, "*.property.clock.value"}, {}, [this](const Event& event) {
      if (event.kind == EventKind::kSet && !event.tuple.value.empty())
        offsets_[event.tuple.owner] = event.tuple.write_time - std::chrono::system_clock::now();
    });
  }
  std::optional<Duration> offset(OwnerId island) const {
    const auto found = offsets_.find(island);
    return found == offsets_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::map<OwnerId, Duration> offsets_;  ///< by the last word of each
  Handle handle_;
};

}  // namespace

std::vector<IslandSeen> look_at_islands(Client& client, Duration between, Duration patience) {
  client.meet();
  const Clocks clocks(client);
  std::vector<IslandSeen> all;
  for (auto& island : client.islands()) {
    auto& seen = all.emplace_back();
    seen.before = client.networks(island.id, patience);
    seen.numbers_before = counters_of(properties_of(client, island.id, patience));
    seen.island = std::move(island);
  }
  client.run_until([] { return false; }, between);
  for (auto& seen : all) {
    const auto id = seen.island.id;
    seen.answers = !client.read({id, "*.island"}, patience).empty();
    seen.now = client.networks(id, patience);
    seen.properties = properties_of(client, id, patience);
    seen.numbers = counters_of(seen.properties);
    seen.clock_offset = clocks.offset(id);
  }
  return all;
}

}  // namespace rubicon::cli
