#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/mqtt/messages.h"
#include "tuples/mqtt/site.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::IsEmpty;
using testing::Key;
using testing::Not;

/// What killed processes left at a broker that keeps it for ever.
struct Leftovers : testing::Test {
  Leftovers() {
    broker.speaks_5 = false;
    broker.rights = transport::MqttRights{{"rubicon-space/1/+/p/#", "rubicon-space/1/+/to/%u/#"},
                                          {"rubicon-space/1/+/p/+/%u/#", "rubicon-space/1/+/to/+/+/%u/+"}};
  }
  std::unique_ptr<Site> site(const std::string& user, OwnerId id) {
    auto options = options_at({kBroker});
    options.brokers.front().user = options.brokers.front().line.user = user;
    return std::make_unique<Site>(time, net, id, "10.0.1." + std::to_string(++addresses), options);
  }
  /// `whole`: with the topic of its connection, which the broker empties only if it lives longer than the process.
  std::string leave(const std::string& user, OwnerId id, bool whole) {
    const auto part = id == kHall ? "a" : "b";
    const auto line = std::string("rubicon-space/1/default/p/") + part + "/" + user + "/00000000000" + part;
    const auto component = line + "/" + std::to_string(number(id));
    broker.publish(component, component_text({1'000'000'000'000'000, "host", {}}), true);
    if (whole) broker.publish(line, line_text({1, 20s}), true);
    return component;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, kBroker};
  int addresses = 0;
};

TEST_F(Leftovers, AreEmptiedByTheirUserAfterAMinute) {
  const auto tool = leave("hall", kRobot, false), of_lab = leave("lab", OwnerId(70001), false);
  auto hall = site("hall", kHall);
  time.run_for(59s);
  EXPECT_THAT(broker.retained(), Contains(Key(tool)));
  time.run_for(3s);
  EXPECT_THAT(broker.retained(), Not(Contains(Key(tool))));
  EXPECT_THAT(broker.retained(), Contains(Key(of_lab)));
  EXPECT_THAT(hall->take(), IsEmpty()) << "it was not met";
}

TEST_F(Leftovers, OfAHostThatWasKilledWithTheBrokerAreThoseThatDoNotAnswer) {
  const auto tool = leave("hall", kRobot, true), former = leave("hall", kHall, true), of_lab = leave("lab", kLab, true);
  auto hall = site("hall", kHall), twin = site("hall", OwnerId(70002));
  const auto before = broker.retained().size();
  time.run_for(2min);
  EXPECT_THAT(broker.retained(), Not(Contains(Key(testing::HasSubstr("/hall/00000000000")))));
  EXPECT_THAT(broker.retained(), Contains(Key(of_lab)));
  EXPECT_EQ(broker.retained().size(), before + 4 - 4) << "whoever lives is there";
  time.run_for(1h);
  EXPECT_EQ(broker.retained().size(), before + 4 - 4);
  EXPECT_THAT(hall->displaced, IsEmpty());
  EXPECT_THAT(hall->take(), IsEmpty()) << "nobody of them was met";
}

TEST_F(Leftovers, WhatALiveProcessShowsIsShownAgain) {
  auto hall = site("hall", kHall);
  time.run_for(5s);
  for (const auto& [topic, payload] : std::map(broker.retained())) broker.publish(topic, {}, true);
  ASSERT_THAT(broker.retained(), IsEmpty());
  time.run_for(3s);
  EXPECT_EQ(broker.retained().size(), 2U);
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
