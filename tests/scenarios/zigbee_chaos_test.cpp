#include <algorithm>
#include <random>

#include "scenarios/zigbee.h"

namespace rubicon::scenarios {
namespace {

using ::testing::Each;
using ::testing::SizeIs;

/// The broker dies and comes back under traffic.
class ZigbeeChaos : public Zigbee, public testing::WithParamInterface<bool> {
 protected:
  static constexpr int kKills = 20;
  /// Every device of the world, as its address.
  std::vector<std::string> addresses() {
    std::vector<std::string> out;
    for (const auto* one : world->registry().devices()) out.push_back(one->address().substr(2));
    return out;
  }
  std::string names() {
    std::string all;
    for (const auto& address : addresses())
      all += address + "=" + seen_json(address + ".description").value("name", "(none)") + " ";
    return all;
  }
};

TEST_P(ZigbeeChaos, TwentyDeathsOfTheBrokerLoseNoDeviceAndRepeatNoCommand) {
  zigbee_simulator::WorldOptions options;
  options.every = 700ms;
  begin_bridge(options);
  start();
  const auto before = names();
  std::mt19937 random(GetParam() ? 1 : 2);
  std::size_t applied = 0;
  const std::string dimmer = "00124b0010000000.actuator.dimmer-1";
  for (int kill = 0; kill < kKills; ++kill) {
    // Each command has a value of its own, so that a repetition is seen.
    applied += command(dimmer, std::to_string(2 * kill + 1)) == tuples::Verdict::kApplied ? 1U : 0U;
    scheduler.run_for(std::chrono::milliseconds(random() % 900));
    applied += command(dimmer, std::to_string(2 * kill + 2)) == tuples::Verdict::kApplied ? 1U : 0U;
    scheduler.run_for(std::chrono::milliseconds(random() % 30));
    broker.stop(GetParam());
    scheduler.run_for(std::chrono::milliseconds(200 + random() % 4000));
    EXPECT_EQ(quality("00124b0010000002.sensor.temperature-1"), "network-down");
    broker.start();
    // The bridge itself tries again each second.
    const auto back = scheduler.now();
    while (line() != "up" && scheduler.now() < back + 10s) scheduler.run_for(10ms);
    EXPECT_LE(scheduler.now() - back, 2s);
    EXPECT_EQ(names(), before);
  }
  scheduler.run_for(60s);
  EXPECT_EQ(names(), before);
  EXPECT_EQ(counter("joins"), 5U);
  EXPECT_EQ(counter("leaves"), 0U);
  EXPECT_EQ(counter("renames"), 0U);
  auto published = sets("lamp");
  EXPECT_GT(published.size(), static_cast<std::size_t>(kKills));
  EXPECT_LE(published.size(), applied);
  std::sort(published.begin(), published.end());
  EXPECT_EQ(std::adjacent_find(published.begin(), published.end()), published.end()) << "no command was sent twice";
  EXPECT_EQ(quality("00124b0010000002.sensor.temperature-1"), "good");
  EXPECT_EQ(command(dimmer, "77"), tuples::Verdict::kApplied);
  scheduler.run_for(5s);
  EXPECT_EQ(seen_json(dimmer + ".status")["command"]["state"], "confirmed");
}

INSTANTIATE_TEST_SUITE_P(Broker, ZigbeeChaos, testing::Values(true, false), [](const auto& persistent) {
  return persistent.param ? "WithPersistence" : "WithoutPersistence";
});

}  // namespace
}  // namespace rubicon::scenarios
