#include "tuples/dds/moves.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_interfaces.h"

namespace rubicon::tuples::dds {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using transport::Interface;

Interface up(const std::string& name, const std::string& address, unsigned index = 1) {
  return {name, address, true, true, false, true, index};
}

/// Moves without a domain: the time of its deletion is tested where there is one.
class MovesOf : public testing::Test {
 protected:
  void begin(std::vector<Interface> there, std::vector<std::string> names = {"eth0"}) {
    host.set(std::move(there));
    moves.emplace(
        std::move(names), time, [this](std::function<void()> call) { time.post(std::move(call)); }, Log(log, "dds"),
        Moves::Callbacks{[this] {
                           ++left;
                           return FormerDomain::Remains{};
                         },
                         [this] { return enter(); }});
    moves->take(host.there());
    moves->follow(host.watch());
    time.run_for(1s);
  }
  Result<void> enter() {
    failed += fails ? 1 : 0;
    if (fails) return fail(ErrorCode::kIo, "no room");
    entered.push_back(moves->take(host.there()));
    return {};
  }

  VirtualScheduler time;
  support::CollectingLog log;
  transport::MemoryInterfaces host{time};
  std::optional<Moves> moves;
  int left = 0;
  bool fails = false;
  int failed = 0;
  std::vector<std::vector<std::string>> entered;
};

TEST_F(MovesOf, AnotherAddressOnceItIsThere) {
  begin({up("eth0", "10.0.0.1")});
  host.set({up("eth0", "")});
  time.run_for(10s);
  EXPECT_EQ(left, 0) << "there is nothing better";
  EXPECT_EQ(moves->news().interfaces.at("eth0").lack, "has no IPv4 address");
  host.set({up("eth0", "10.0.0.2")});
  const auto now = time.wall_now();
  time.run_for(1s);
  EXPECT_EQ(left, 1);
  EXPECT_THAT(entered, ElementsAre(ElementsAre("eth0")));
  EXPECT_EQ(moves->news().changes, 1U);
  EXPECT_GE(moves->news().changed, now);
  EXPECT_EQ(moves->news().interfaces.at("eth0"), (InterfaceNews::State{"10.0.0.2", ""}));
  time.run_for(1min);
  EXPECT_EQ(left, 1);
}

TEST_F(MovesOf, ManyChangesAtATimeAreOne) {
  begin({up("eth0", "10.0.0.1")});
  for (int i = 2; i < 100; ++i) {
    host.set({up("eth0", "10.0.0." + std::to_string(i))});
    time.run_for(1ms);
  }
  time.run_for(1s);
  EXPECT_EQ(left, 1);
}

TEST_F(MovesOf, ALinkThatComesBackChangesNothing) {
  begin({up("eth0", "10.0.0.1"), up("wlan0", "10.0.1.1", 2)});
  auto without_link = up("eth0", "10.0.0.1");
  without_link.has_link = false;
  host.set({without_link});
  time.run_for(1s);
  EXPECT_EQ(moves->news().interfaces.at("eth0").lack, "has no link (cable or Wi-Fi)");
  host.set({up("eth0", "10.0.0.1")});
  time.run_for(1s);
  EXPECT_EQ(left, 0) << "nor an interface that is not one of ours";
  EXPECT_TRUE(log.contains("interface eth0 (10.0.0.1) is back"));
}

TEST_F(MovesOf, OneThatIsDownIsNotUsedWhateverItsAddress) {
  begin({up("eth0", "10.0.0.1")});
  auto down = up("eth0", "10.0.0.2");
  down.is_up = false;
  host.set({down});
  time.run_for(1s);
  EXPECT_EQ(left, 0);
  EXPECT_TRUE(log.contains("interface eth0 is down: it reaches no other host"));
}

TEST_F(MovesOf, OneThatWasPluggedInAgainIsAnother) {
  begin({up("eth0", "10.0.0.1", 7)});
  host.set({up("eth0", "10.0.0.1", 8)});
  time.run_for(1s);
  EXPECT_EQ(left, 1);
}

TEST_F(MovesOf, OfTwoTheOtherOneIsUsedAlone) {
  begin({up("eth0", "10.0.0.1"), up("wlan0", "10.0.1.1", 2)}, {"eth0", "wlan0"});
  host.set({up("wlan0", "10.0.1.1", 2)});
  time.run_for(1s);
  EXPECT_THAT(entered, ElementsAre(ElementsAre("wlan0")));
  EXPECT_EQ(moves->news().interfaces.at("eth0").lack, "is not there");
  host.set({up("eth0", "10.0.0.1"), up("wlan0", "10.0.1.1", 2)});
  time.run_for(1s);
  EXPECT_THAT(entered.back(), ElementsAre("eth0", "wlan0"));
}

TEST_F(MovesOf, ItTriesAgainUntilItIsIn) {
  begin({up("eth0", "10.0.0.1")});
  fails = true;
  host.set({up("eth0", "10.0.0.2")});
  time.run_for(10s);
  EXPECT_TRUE(moves->under_way());
  EXPECT_TRUE(log.contains("no room"));
  fails = false;
  host.set({up("eth0", "10.0.0.3")});
  time.run_for(2s);
  EXPECT_FALSE(moves->under_way());
  EXPECT_EQ(entered.size(), 1U) << "with what is there then";
  EXPECT_GE(failed, 5);
  EXPECT_EQ(left, 1 + failed) << "links that came back leave again";
}

/// Nobody tells of it.
TEST_F(MovesOf, WhatChangedBeforeTheFirstWatchIsSeen) {
  host.set({up("eth0", "10.0.0.2")});
  moves.emplace(
      std::vector<std::string>{"eth0"}, time, [this](std::function<void()> call) { time.post(std::move(call)); },
      Log(log, "dds"), Moves::Callbacks{[] { return FormerDomain::Remains{}; }, [this] { return enter(); }});
  moves->take({up("eth0", "10.0.0.1")});
  moves->follow(host.watch());
  time.run_for(1s);
  EXPECT_EQ(entered.size(), 1U);
}

TEST_F(MovesOf, ItStaysOutsideAsLongAsItIsAsked) {
  begin({up("eth0", "10.0.0.1")});
  moves->move_anyway(5s);
  EXPECT_EQ(left, 0) << "not inside of the call";
  time.run_for(4s);
  EXPECT_EQ(left, 1);
  EXPECT_TRUE(entered.empty());
  time.run_for(2s);
  EXPECT_EQ(entered.size(), 1U);
  moves->move_anyway(0s);
  time.run_for(10ms);
  EXPECT_EQ(entered.size(), 2U) << "at once";
}

}  // namespace
}  // namespace rubicon::tuples::dds
