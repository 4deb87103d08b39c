#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

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

struct WhoIsLookedFor : testing::Test {
  Search::Callbacks calls() {
    Search::Callbacks calls;
    calls.subscribe = [this](const std::string& filter) {
      filters.insert(filter);
      ++subscribed;
    };
    calls.unsubscribe = [this](const std::string& filter) { filters.erase(filter); };
    calls.fence = [this](std::uint64_t number) { step = number; };
    calls.late = [] {};
    calls.complete = [](bool) {};
    calls.line_read = [](const Line&) {};
    return calls;
  }
  /// The broker has sent all that was asked for.
  void finish() {
    while (!search.idle()) search.passed(step);
  }
  void leave(OwnerId id) {
    search.drop(id);
    search.forget(id);
  }
  bool has(OwnerId id) const { return filters.contains(topics.component_filter(id)); }
  bool has_all() const { return filters.contains(topics.presence_filter('0')); }

  base::VirtualScheduler time;
  const Topics topics{"default"};
  std::set<std::string> filters;
  int subscribed = 0;
  std::uint64_t step = 0;
  Search search{topics, time, calls()};
};

TEST_F(WhoIsLookedFor, OfOneUserAreNotMoreThanIsReadSoon) {
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

TEST_F(WhoIsLookedFor, UsersWithoutRoomTakeNoMemory) {
  for (std::uint32_t i = 0; i < Search::kMaxLines; ++i) search.line(line_of(std::to_string(i % 100), i));
  const auto before = ::mallinfo2().uordblks;
  for (std::uint32_t i = 0; i < 100'000; ++i) EXPECT_FALSE(search.line(line_of(fmt::format("user{}", i), i)));
  EXPECT_LT(::mallinfo2().uordblks, before + 1'000'000);
}

TEST_F(WhoIsLookedFor, AConnectionThatComesAndGoesIsReadOnce) {
  search.connected();
  const auto line = line_of("hall", 1);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(search.line(line));
    search.forget(line);
  }
  EXPECT_TRUE(search.line(line));
  finish();
  EXPECT_EQ(subscribed, 1);
  EXPECT_EQ(filters.size(), 1U);
  EXPECT_FALSE(search.line(line)) << "it was read";
}

TEST_F(WhoIsLookedFor, AComponentIsForgottenByTheLastOneWhoKeepsIt) {
  constexpr OwnerId kLamp{7};
  search.connected();
  search.keep(kLamp);
  search.keep(kLamp);
  finish();
  leave(kLamp);
  EXPECT_TRUE(has(kLamp));
  EXPECT_TRUE(search.knows(kLamp));
  search.drop(kLamp);
  EXPECT_TRUE(has(kLamp)) << "it may still be there";
  search.keep(kLamp);
  search.forget(kLamp);
  EXPECT_TRUE(has(kLamp)) << "it is kept again";
  leave(kLamp);
  EXPECT_FALSE(has(kLamp));
  EXPECT_FALSE(search.wants({}, kLamp));
  EXPECT_EQ(subscribed, 1);
}

TEST_F(WhoIsLookedFor, AComponentIsForgottenBeforeItWasRead) {
  constexpr OwnerId kLamp{7};
  search.connected();
  search.keep(kLamp);
  leave(kLamp);
  finish();
  EXPECT_EQ(subscribed, 0) << "it waited";
  search.keep(kLamp);
  EXPECT_TRUE(has(kLamp)) << "under way";
  leave(kLamp);
  search.keep(kLamp);
  EXPECT_FALSE(has(kLamp)) << "after that";
  search.passed(step);
  EXPECT_TRUE(has(kLamp));
  EXPECT_FALSE(search.knows(kLamp));
  finish();
  EXPECT_TRUE(search.knows(kLamp));
}

TEST_F(WhoIsLookedFor, ThoseThatComeAndGoLeaveNothing) {
  search.connected();
  finish();
  for (std::uint32_t id = 1; id < 3 * Search::kMaxSought; ++id) {
    search.keep(OwnerId(id));
    finish();
    leave(OwnerId(id));
  }
  EXPECT_TRUE(filters.empty());
}

/// A command names them, and nothing tells when it has ended.
TEST_F(WhoIsLookedFor, ThoseThatSomebodyAskedForGiveWay) {
  search.connected();
  search.keep(OwnerId(1));
  for (std::uint32_t id = 2; id < 3 * Search::kMaxSought; ++id) {
    search.component(OwnerId(id));
    finish();
    EXPECT_TRUE(search.knows(OwnerId(id)));
  }
  EXPECT_FALSE(has_all());
  EXPECT_LE(filters.size(), Search::kMaxSought);
  EXPECT_TRUE(has(OwnerId(1)));
}

TEST_F(WhoIsLookedFor, ThoseThatWaitForAnAnswerDoNotGiveWay) {
  search.connected();
  for (std::uint32_t id = 1; id <= Search::kMaxSought + 1; ++id) search.component(OwnerId(id));
  finish();
  EXPECT_TRUE(search.knows_all());
  EXPECT_TRUE(has_all());
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
