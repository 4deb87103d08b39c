#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "support/conversation.h"
#include "support/private_network.h"
#include "support/process.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using support::Process;
using support::until;
using Clock = std::chrono::steady_clock;

const std::string kMember = RUBICON_BINARY_DIR "/bin/ecology-member";
constexpr auto kLease = 1s;

/// Components in separate processes, on a host of their own.
class Faults : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  static std::unique_ptr<Process> member(int id) {
    return std::make_unique<Process>(std::vector<std::string>{kMember, std::to_string(id), GetParam()});
  }
  static auto equals(const std::string& name, const json& value) {
    return [name, value](const json& answer) { return answer.contains(name) && answer[name] == value; };
  }
  static testing::AssertionResult meet(Process& one, std::vector<int> others) {
    return until(one, "peers", 60s, equals("peers", others));
  }

  support::PrivateNetwork alone_;
};

INSTANTIATE_TEST_SUITE_P(On, Faults, testing::Values("host", "dds"), [](const auto& of) { return of.param; });

TEST_P(Faults, DemandIsTheUnionOfTheLivingAfterTenThousandChanges) {
  constexpr int kKeys = 20, kChanges = 10'000, kOthers = 4;
  auto owner = member(70000);
  for (int i = 0; i < kKeys; ++i) ASSERT_EQ(ask(*owner, "set t.k" + std::to_string(i) + " x")["ok"], true);
  std::vector<std::unique_ptr<Process>> others;
  std::vector<std::map<std::string, std::string>> wants(kOthers);  // pattern by subscription, of the active ones
  for (int i = 0; i < kOthers; ++i) others.push_back(member(70001 + i));
  std::mt19937 dice(4711);
  const auto roll = [&](int sides) { return static_cast<int>(dice() % static_cast<unsigned>(sides)); };
  for (int change = 0; change < kChanges; ++change) {
    const auto who = static_cast<std::size_t>(roll(kOthers));
    if (roll(1000) == 0) {
      others[who]->signal(SIGKILL);
      others[who] = member(70001 + static_cast<int>(who));
      wants[who].clear();
      continue;
    }
    const auto name = "s" + std::to_string(roll(8));
    const bool passive = roll(4) == 0;
    const auto pattern = roll(10) == 0 ? std::string("70000:t.*") : "*:t.k" + std::to_string(roll(kKeys));
    if (roll(2) == 0) {
      ASSERT_EQ(ask(*others[who], "sub " + name + " " + pattern + (passive ? " passive" : ""))["ok"], true);
      wants[who].erase(name);
      if (!passive) wants[who][name] = pattern;
    } else {
      ask(*others[who], "unsub " + name);
      wants[who].erase(name);
    }
  }
  // A last subscription for all but a few components, so that the result is neither all nor none.
  std::set<std::string> union_of_all;
  for (std::size_t i = 0; i < wants.size(); ++i) {
    for (const auto& [name, pattern] : std::map(wants[i])) {
      if (pattern.ends_with('*')) {
        ask(*others[i], "unsub " + name);
      } else {
        union_of_all.insert(pattern.substr(2));
      }
    }
  }
  EXPECT_TRUE(until(*owner, "wanted", 60s, equals("wanted", union_of_all)));
  EXPECT_LT(union_of_all.size(), static_cast<std::size_t>(kKeys));
  EXPECT_FALSE(union_of_all.empty());
  std::this_thread::sleep_for(kLease);
  EXPECT_TRUE(until(*owner, "wanted", 60s, equals("wanted", union_of_all))) << "later news changed it for good";
}

TEST_P(Faults, WhoIsKilledIsShownAndItsDemandEnds) {
  auto owner = member(70000), reader = member(70001);
  ASSERT_EQ(ask(*owner, "set t.k 1")["ok"], true);
  ASSERT_EQ(ask(*reader, "sub a *:t.k")["ok"], true);
  ASSERT_TRUE(until(*owner, "wanted", 60s, equals("wanted", {"t.k"})));
  ASSERT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "1"}})));
  reader->signal(SIGKILL);
  EXPECT_TRUE(until(*owner, "wanted", 60s, equals("wanted", json::array())));
  reader = member(70001);
  ASSERT_EQ(ask(*reader, "sub a *:t.k")["ok"], true);
  ASSERT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "1"}})));
  owner->signal(SIGKILL);
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "1 (absent)"}})));
  owner = member(70000);
  ASSERT_EQ(ask(*owner, "set t.k 2")["ok"], true);
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "2"}})));
}

TEST_P(Faults, AStoppedSubscriberIsLostAndCatchesUp) {
  auto owner = member(70000), reader = member(70001);
  ASSERT_EQ(ask(*reader, "sub a *:t.*")["ok"], true);
  for (int i = 0; i < 50; ++i) ask(*owner, "set t.k" + std::to_string(i) + " 0");
  ASSERT_TRUE(until(*reader, "copies", 60s, [](const json& answer) { return answer["copies"].size() == 50; }));
  reader->signal(SIGSTOP);
  ask(*owner, "set t.k0 1");  // on a host nobody asks a process that is quiet
  EXPECT_TRUE(until(*owner, "wanted", 60s, equals("wanted", json::array())));
  json last = json::object();
  for (int i = 0; i < 50; ++i) {
    const auto key = "t.k" + std::to_string(i);
    if (i % 10 == 0) {
      ask(*owner, "erase " + key);
    } else {
      ask(*owner, "set " + key + " new");
      last["70000:" + key] = "new";
    }
  }
  reader->signal(SIGCONT);
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", last)));
  EXPECT_TRUE(until(*owner, "wanted", 60s, [](const json& answer) { return answer["wanted"].size() == 45; }));
}

TEST_P(Faults, AStoppedOwnerIsShownAndItsWordCountsWhenItGoesOn) {
  auto owner = member(70000), reader = member(70001);
  ASSERT_EQ(ask(*owner, "set t.k 1")["ok"], true);
  ASSERT_EQ(ask(*reader, "sub a *:t.k")["ok"], true);
  ASSERT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "1"}})));
  owner->signal(SIGSTOP);
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "1 (absent)"}})));
  ask(*reader, "command 70000 1");
  EXPECT_EQ(ask(*reader, "answers")["answers"].value("applied", 0), 0);
  owner->signal(SIGCONT);
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "1"}})));
  ask(*owner, "set t.k 2");
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", {{"70000:t.k", "2"}})));
  EXPECT_TRUE(until(*owner, "wanted", 60s, equals("wanted", {"t.k"})));
}

TEST_P(Faults, CommandsAndMessagesOfManyAreTakenOnceAndInOrder) {
  constexpr int kEach = 3000, kSenders = 3;
  auto owner = member(70000);
  std::vector<std::unique_ptr<Process>> senders;
  for (int i = 0; i < kSenders; ++i) senders.push_back(member(70001 + i));
  for (auto& sender : senders)
    ASSERT_TRUE(until(*sender, "peers", 60s, [](const json& answer) { return answer["peers"].size() == kSenders; }));
  const auto all = std::to_string(kEach);
  for (auto& sender : senders) ask(*sender, "command 70000 " + all);
  owner->signal(SIGSTOP);  // shorter than the lease: delayed, not lost
  std::this_thread::sleep_for(kLease / 10);
  owner->signal(SIGCONT);
  for (int i = 0; i < kSenders; ++i) {
    EXPECT_TRUE(until(*senders[static_cast<std::size_t>(i)], "answers", 60s, equals("answers", {{"applied", kEach}})));
    const auto counted = ask(*owner, "commands " + std::to_string(70001 + i));
    EXPECT_EQ(counted["count"], kEach);
    EXPECT_EQ(counted["disordered"], 0);
  }
}

TEST_P(Faults, UserMessagesArriveOnceAndInOrder) {
  constexpr int kAll = 2000;
  auto reader = member(70000), sender = member(70001);
  ASSERT_TRUE(meet(*sender, {70000}));
  ask(*sender, "send 70000 " + std::to_string(kAll));
  EXPECT_TRUE(until(*sender, "answers", 60s, equals("answers", {{"", kAll}})));
  const auto heard = ask(*reader, "heard 70001");
  EXPECT_EQ(heard["count"], kAll);
  EXPECT_EQ(heard["disordered"], 0);
}

TEST_P(Faults, ThousandsOfSubscriptionsLeaveNothingBehind) {
  auto owner = member(70000), reader = member(70001), other = member(70002);
  for (int i = 0; i < 20; ++i) ask(*owner, "set t.k" + std::to_string(i) + " x");
  ASSERT_EQ(ask(*other, "sub a 70000:t.k3")["ok"], true);
  ASSERT_TRUE(meet(*reader, {70000, 70002}));
  EXPECT_EQ(ask(*reader, "churn 3000")["ok"], true);
  EXPECT_TRUE(until(*owner, "wanted", 60s, equals("wanted", {"t.k3"})));
  EXPECT_TRUE(until(*reader, "copies", 60s, equals("copies", json::object())));
  ask(*owner, "set t.k3 last");
  EXPECT_TRUE(until(*other, "copies", 60s, equals("copies", {{"70000:t.k3", "last"}})));
}

}  // namespace
}  // namespace rubicon::ecology
