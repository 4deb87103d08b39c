#include <gmock/gmock.h>

#include <random>

#include "scenarios/roaming.h"

namespace rubicon::scenarios {
namespace {

using testing::Le;
using testing::SizeIs;

constexpr std::uint32_t kRoamingIslands = 3;
constexpr int kRoamingDevices = 8;

/// Devices move between three islands that crash, restart and lose each other.
class RoamingChaos : public Roaming, public testing::WithParamInterface<unsigned> {
 protected:
  void begin() {
    for (std::uint32_t id = 1; id <= kRoamingIslands; ++id) {
      states[id] = state_file();
      start_with_state(id, states[id]);
    }
    for (int i = 0; i < kRoamingDevices; ++i)
      lists.try_emplace(std::to_string(i), watcher(), std::to_string(i), scheduler);
  }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random() % count); }
  std::uint32_t any_island() { return 1 + below(kRoamingIslands); }

  void join_at(const std::string& device, std::uint32_t island) {
    if (islands.contains(island)) join(island, device);
  }
  void words() {
    for (const auto& [device, islands_near] : near) {
      for (const auto island : islands_near) {
        if (islands.contains(island)) word(island, device);
      }
    }
  }
  void move() {
    const auto device = std::to_string(below(kRoamingDevices));
    auto& place = near[device];
    place = {any_island()};
    if (below(3) == 0) place.insert(any_island());
    for (const auto island : place) join_at(device, island);
  }
  void wander_without_a_word() { near[std::to_string(below(kRoamingDevices))] = {any_island()}; }
  void leave() {
    const auto device = std::to_string(below(kRoamingDevices));
    for (const auto island : std::exchange(near[device], {})) {
      if (islands.contains(island)) devices_of(island).say(device, model::Leave{"off"});
    }
  }
  void cut_or_mend() {
    const auto one = any_island(), other = 1 + one % kRoamingIslands;
    below(2) == 0 ? ecology.cut(OwnerId(one), OwnerId(other)) : ecology.mend(OwnerId(one), OwnerId(other));
  }
  void stop_or_start() {
    const auto id = any_island();
    if (islands.contains(id)) return stop(id);
    start_with_state(id, states[id]);
    for (const auto& [device, place] : near) {
      if (place.contains(id) && below(2) == 0) join(id, device);
    }
  }
  void step() {
    switch (below(12)) {
      case 0: return leave();
      case 1: return cut_or_mend();
      case 2: return stop_or_start();
      case 3: return wander_without_a_word();
      case 4: return words();
      case 5: return scheduler.run_for(std::chrono::milliseconds(below(1000)));
      case 6: return scheduler.run_for(std::chrono::seconds(below(30)));
      default: return move();
    }
  }
  /// Repairs everything; each device announces itself and goes on reporting.
  void rest() {
    for (std::uint32_t one = 1; one <= kRoamingIslands; ++one)
      ecology.mend(OwnerId(one), OwnerId(1 + one % kRoamingIslands));
    for (std::uint32_t id = 1; id <= kRoamingIslands; ++id) {
      if (!islands.contains(id)) start_with_state(id, states[id]);
    }
    for (const auto& [device, place] : near) {
      for (const auto island : place) join(island, device);
    }
    for (int i = 0; i < 12; ++i) {
      scheduler.run_for(10s);
      words();
    }
    scheduler.run_for(1s);
  }
  void check() {
    for (const auto& [device, list] : lists) {
      const auto owners = list.owners();
      EXPECT_THAT(owners, SizeIs(Le(1U))) << device;
      EXPECT_TRUE(near[device].empty() || !owners.empty()) << device << " is listed by nobody";
      for (const auto owner : owners) {
        const auto heard = near[device].empty() || near[device].contains(owner);
        EXPECT_TRUE(heard) << device << " is listed by " << owner << ", which does not hear it";
      }
      for (std::uint32_t id = 1; id <= kRoamingIslands; ++id) {
        const bool lists_it = std::find(owners.begin(), owners.end(), id) != owners.end();
        EXPECT_EQ(value(islands[id]->space(), id, "ROAMING.lab." + device) != "(none)", lists_it) << device << id;
      }
    }
  }

  std::mt19937 random{GetParam()};
  std::map<std::uint32_t, std::string> states;
  std::map<std::string, std::set<std::uint32_t>> near;  ///< the islands that hear a device
  std::map<std::string, Listing> lists;
};

TEST_P(RoamingChaos, AtRestExactlyOneIslandListsEachDevice) {
  begin();
  for (int i = 0; i < 2000; ++i) {
    step();
    if (i % 200 != 199) continue;
    rest();
    check();
    if (HasFailure()) return void(ADD_FAILURE() << "after " << i << " steps");
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoamingChaos, testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace rubicon::scenarios
