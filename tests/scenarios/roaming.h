#pragma once

#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "scenarios/ecology.h"
#include "state/state_store.h"

namespace rubicon::scenarios {

inline constexpr const char* kLab = "roaming: lab";

/// The islands that list one device at the moment, seen by a component that is never cut off.
class Listing {
 public:
  Listing(TupleSpace& space, const std::string& device, const Scheduler& scheduler)
      : scheduler_(scheduler),
        ears_(space.subscribe({std::nullopt, "proxy.*." + device + ".status"}, {.passive = true},
                              [this](const Event& event) { take(event); })) {}

  Listing(const Listing&) = delete;
  Listing& operator=(const Listing&) = delete;

  std::vector<std::uint32_t> owners() const {
    std::vector<std::uint32_t> all;
    for (const auto& [owner, key] : there_) all.push_back(number(owner));
    return all;
  }
  /// The longest time in which more than one listed it.
  Duration overlap() const { return std::max(longest_, there_.size() > 1 ? scheduler_.now() - since_ : Duration(0)); }
  /// How often an island began to list it.
  int begins() const { return begins_; }

 private:
  void take(const Event& event) {
    const auto before = there_.size();
    if (before > 1) longest_ = std::max(longest_, scheduler_.now() - since_);
    const std::pair place(event.tuple.owner, std::string(event.tuple.key));
    if (event.kind != EventKind::kSet) {
      there_.erase(place);
    } else if (there_.insert(place).second) {
      ++begins_;
    }
    if (before < 2 && there_.size() > 1) since_ = scheduler_.now();
  }

  const Scheduler& scheduler_;
  std::set<std::pair<OwnerId, std::string>> there_;
  SteadyTime since_{};
  Duration longest_{0};
  int begins_ = 0;
  Handle ears_;
};

/// Islands between which devices roam.
class Roaming : public Ecology {
 protected:
  ~Roaming() override {
    for (const auto& folder : folders_) std::filesystem::remove_all(folder);
  }

  TupleSpace& watcher() { return component(70009); }
  Listing listing(const std::string& device = "7") { return Listing(watcher(), device, scheduler); }

  /// An island from its configuration text, with a state file if one is given.
  island::Island& start_text(std::uint32_t id, const std::string& text, const std::string& state = {}) {
    const auto tree = config::parse_yaml("island: {id: " + std::to_string(id) + ", name: test}\n" + text, "i.yaml");
    base::ConfigErrors errors;
    auto config = island::read_island_config(tree.value(), std::span(&kScripted, 1), errors);
    std::unique_ptr<state::StateStore> store;
    if (!state.empty()) store = std::move(*state::StateStore::open(state, OwnerId(id), {}));
    auto made = island::Island::make(std::move(config), scheduler, transports, log, ecology, errors, std::move(store));
    EXPECT_TRUE(made.has_value()) << errors.text();
    auto& island = *(islands[id] = std::move(*made));
    island.start();
    scheduler.run_ready();
    return island;
  }
  island::Island& start_with_state(std::uint32_t id, const std::string& state) {
    return start_text(id, "networks: {scripted-1: {type: scripted, roaming: lab}}", state);
  }
  void stop(std::uint32_t id) {
    islands.erase(id);
    scheduler.run_ready();
  }
  std::string state_file() {
    folders_.push_back(testing::TempDir() + "rubicon-roaming-XXXXXX");
    EXPECT_NE(::mkdtemp(folders_.back().data()), nullptr);
    return folders_.back() + "/island.state";
  }
  static island::IslandConfig read(const std::string& text, base::ConfigErrors& errors) {
    return island::read_island_config(config::parse_yaml(text, "i.yaml").value(), std::span(&kScripted, 1), errors);
  }

  void join(std::uint32_t island, const std::string& device = "7") { devices_of(island).say(device, lamp()); }
  void word(std::uint32_t island, const std::string& device = "7") {
    devices_of(island).say(device, model::KeepAlive{});
  }
  nlohmann::json claim(std::uint32_t island, const std::string& part = "7") {
    return json(islands.at(island)->space(), island, "ROAMING.lab." + part);
  }

 private:
  std::vector<std::string> folders_;
};

}  // namespace rubicon::scenarios
