#include <gmock/gmock.h>

#include "island/network_types.h"
#include "scenarios/ecology.h"

namespace rubicon::scenarios {
namespace {

using testing::HasSubstr;

constexpr const char* kHome = "island: {id: 6541, name: home}\nnetworks:\n";
constexpr const char* kReplay =
    "  log-table:\n    type: log\n    format: csv\n    file: a.csv\n    period: 1s\n    silence: never\n"
    "    map: {room: {columns: {t: {sensor: temperature-1}}}}\n";

/// An island that plays the values 1 to 100, one a second, and a component that sets its replay.
class ReplayOfAnIsland : public Ecology {
 protected:
  void SetUp() override {
    std::string table = "t\n";
    for (int i = 1; i <= 100; ++i) table += std::to_string(i) + "\n";
    transports.put("a.csv", table);
    auto made = island::Island::make(read(std::string(kHome) + kReplay), scheduler, transports, log, ecology, errors);
    ASSERT_TRUE(made) << errors.text();
    island = std::move(*made);
    viewer = &component(70001);
    everything = viewer->subscribe({OwnerId(6541), "**"}, {.passive = true}, [this](const Event& event) {
      if (event.tuple.key == kPosition) ++positions;
    });
    island->start();
    scheduler.run_for(10500ms);
  }
  island::IslandConfig read(const std::string& text) {
    const auto tree = config::parse_yaml(text, "island.yaml");
    return island::read_island_config(tree.value(), island::network_types(), errors);
  }
  /// The final status of the command.
  nlohmann::json command(const std::string& property, std::string_view text) {
    const auto key = "proxy.log-table.property." + property;
    viewer->set_remote(OwnerId(6541), key + ".command", text, 5s, [](const tuples::Reply&) {});
    scheduler.run_for(100ms);
    auto status = json(*viewer, 6541, key + ".status");
    return status.is_object() ? status["command"] : nlohmann::json();
  }
  std::string shown(const std::string& property) {
    scheduler.run_for(1s);
    return value(*viewer, 6541, "proxy.log-table.property." + property + ".value");
  }
  std::string temperature() { return value(*viewer, 6541, "proxy.log-table.room.sensor.temperature-1.value"); }

  static constexpr const char* kPosition = "proxy.log-table.property.replay-position.value";
  base::ConfigErrors errors;
  std::unique_ptr<island::Island> island;
  TupleSpace* viewer = nullptr;
  Handle everything;
  int positions = 0;
};

TEST_F(ReplayOfAnIsland, IsPausedSearchedAndPlayedByCommands) {
  EXPECT_EQ(temperature(), "11");
  EXPECT_EQ(command("replay-state", "paused")["state"], "confirmed");
  EXPECT_EQ(shown("replay-state"), "paused");
  const auto paused_at = temperature();
  scheduler.run_for(1min);
  EXPECT_EQ(temperature(), paused_at);
  EXPECT_EQ(command("replay-position", "50.5")["state"], "confirmed");
  EXPECT_EQ(temperature(), "51");
  EXPECT_EQ(shown("replay-position"), "50.500");
  EXPECT_EQ(command("replay-position", "5")["state"], "confirmed");
  EXPECT_EQ(temperature(), "5");
  EXPECT_EQ(command("replay-speed", "10")["state"], "confirmed");
  EXPECT_EQ(command("replay-state", "playing")["state"], "confirmed");
  scheduler.run_for(950ms);
  EXPECT_EQ(temperature(), "16");
  EXPECT_EQ(shown("replay-speed"), "10");
}

TEST_F(ReplayOfAnIsland, PublishesThePositionOnceASecond) {
  positions = 0;
  scheduler.run_for(20s);
  EXPECT_GE(positions, 19);
  EXPECT_LE(positions, 21);
}

TEST_F(ReplayOfAnIsland, RefusalsAreClear) {
  const auto refused = command("replay-position", "soon");
  EXPECT_EQ(refused["state"], "refused");
  EXPECT_THAT(refused["reason"].get<std::string>(), HasSubstr("'soon', expected seconds"));
  EXPECT_EQ(refused["creator"], 70001);
  EXPECT_EQ(command("replay-speed", "0")["state"], "refused");
  EXPECT_EQ(command("replay-volume", "1"), nlohmann::json());
}

TEST_F(ReplayOfAnIsland, DescribesWhatCanBeSet) {
  const auto about = json(*viewer, 6541, "proxy.log-table.property.replay-state.description");
  EXPECT_EQ(about["words"], nlohmann::json({"playing", "paused"}));
  EXPECT_EQ(about["access"], "read-write");
  EXPECT_EQ(json(*viewer, 6541, "proxy.log-table.property.replay-position.description")["unit"], "s");
}

TEST_F(ReplayOfAnIsland, GoesWithItsNetwork) {
  ASSERT_TRUE(island->reload(read(std::string(kHome) + "  dummy-1: {type: dummy, simulate: {}}\n"), errors))
      << errors.text();
  scheduler.run_for(2s);
  EXPECT_EQ(value(*viewer, 6541, "proxy.log-table.property.replay-state.command"), "(none)");
  EXPECT_EQ(value(*viewer, 6541, "proxy.log-table.property.replay-state.value"), "(none)");
  ASSERT_TRUE(island->reload(read(std::string(kHome) + kReplay), errors)) << errors.text();
  scheduler.run_for(3s);
  EXPECT_EQ(command("replay-state", "paused")["state"], "confirmed");
}

}  // namespace
}  // namespace rubicon::scenarios
