#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "tuples/mqtt/presence.h"
#include "tuples/mqtt/search.h"
#include "tuples/mqtt/uplink.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;

Line line_of(const std::string& user, std::uint32_t number) {
  return {user, fmt::format("{:012x}", number)};
}

TEST(WhoIsPresent, AComponentThatIsDoubtedLeavesTheOthersOfItsConnection) {
  base::VirtualScheduler time;
  Presence presence(time, {[](OwnerId, PeerEvent) {}, [](const Line&) {}});
  const auto line = line_of("hall", 1);
  presence.show(line, LineShown{1, 20s});
  for (const auto id : {1, 2}) presence.show(line, OwnerId(id), ComponentShown{7, "host", {}});
  presence.doubt(line, OwnerId(2), true);
  presence.review_all();
  EXPECT_TRUE(presence.reached(OwnerId(1)));
  EXPECT_FALSE(presence.reached(OwnerId(2)));
  presence.doubt(line, OwnerId(2), false);
  EXPECT_TRUE(presence.reached(OwnerId(2)));
}

TEST(WhoIsLookedFor, OfOneUserAreNotMoreThanIsReadSoon) {
  base::VirtualScheduler time;
  const Topics topics("default");
  std::set<std::string> filters;
  std::uint64_t step = 0;
  Search::Callbacks calls;
  calls.subscribe = [&](const std::string& filter) { filters.insert(filter); };
  calls.unsubscribe = [&](const std::string& filter) { filters.erase(filter); };
  calls.fence = [&](std::uint64_t number) { step = number; };
  calls.late = [] {};
  calls.complete = [](bool) {};
  calls.line_read = [](const Line&) {};
  Search search(topics, time, calls);
  search.connected();
  const auto look = [&](const std::string& user, std::uint32_t count) {
    std::size_t wanted = 0;
    for (std::uint32_t i = 0; i < count; ++i) search.line(line_of(user, i));
    for (std::uint32_t i = 0; i < count; ++i) wanted += search.wants(line_of(user, i), {}) ? 1U : 0U;
    return wanted;
  };
  EXPECT_EQ(look("mad", 1000), Search::kMaxUnread);
  EXPECT_EQ(look("ann", 1), 1U);
  for (int i = 0; i < 10; ++i) search.passed(step);
  EXPECT_EQ(filters.size(), Search::kMaxUnread + 1);
  EXPECT_EQ(look("mad", 1000), 2 * Search::kMaxUnread) << "those were read";
  for (std::uint32_t user = 0; user < 100; ++user) look(std::to_string(user), Search::kMaxUnread);
  for (int i = 0; i < 1000; ++i) search.passed(step);
  EXPECT_EQ(filters.size(), Search::kMaxLines);
}

/// Counts attempts to connect.
struct CountingTransports final : transport::Transports {
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return machine.open_file(path);
  }
  Result<std::unique_ptr<transport::MqttLine>> open_mqtt(const transport::MqttOptions& options,
                                                         transport::MqttCallbacks calls) override {
    ++opened;
    return machine.open_mqtt(options, std::move(calls));
  }
  transport::MemoryTransports machine;
  int opened = 0;
};

struct Attempts : testing::Test {
  /// In ten minutes, to so many brokers.
  int attempts(int brokers) {
    transports.machine.join(net, "10.0.0.9");
    std::vector<SpaceBroker> all(static_cast<std::size_t>(brokers));
    for (int i = 0; i < brokers; ++i) all[static_cast<std::size_t>(i)].line.host = fmt::format("10.0.0.{}", i + 1);
    Uplink::Callbacks calls;
    calls.begins = [](const std::string&) { return transport::MqttWill{"will", {}, true, 1}; };
    base::LimitedLog limited(base::Log(log, "mqtt"), time);
    Uplink uplink(all, 5s, time, transports, limited, calls);
    EXPECT_TRUE(uplink.open());
    time.run_for(10min);
    EXPECT_EQ(uplink.line(), nullptr);
    EXPECT_FALSE(uplink.trouble().empty());
    return transports.opened;
  }

  base::VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker one{net, {"10.0.0.1", 1883}}, two{net, {"10.0.0.2", 1883}};
  support::CollectingLog log;
  CountingTransports transports;
};

TEST_F(Attempts, AtABrokerThatIsAwayAreMadeEachTenSeconds) {
  one.stop(true);
  EXPECT_THAT(attempts(1), testing::AllOf(testing::Ge(40), testing::Le(130)));
}

TEST_F(Attempts, AtABrokerThatRefusesAreMadeEachHalfMinute) {
  one.users = {{"ann", "secret"}};
  EXPECT_THAT(attempts(1), testing::AllOf(testing::Ge(13), testing::Le(42)));
}

TEST_F(Attempts, AtSeveralThatRefuseAreSeldomToo) {
  one.users = two.users = {{"ann", "secret"}};
  EXPECT_THAT(attempts(2), testing::AllOf(testing::Ge(20), testing::Le(84)));
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
