#include <array>

#include "tuples/carry/wires.h"

namespace rubicon::tuples::carry {
namespace {

using namespace std::chrono_literals;
using testing::Each;
using testing::Le;
using testing::SizeIs;

/// Three sites, each with DDS; three brokers, each between two sites; two carriers between each site and each of its
/// brokers. At each site a robot, at each broker a laptop.
struct Ring : testing::Test {
  static constexpr std::size_t kSites = 3;
  struct Carrying {
    std::uint32_t id;
    std::size_t site, broker;
    std::unique_ptr<Site<>> process;
  };

  void SetUp() override {
    for (std::size_t i = 0; i < kSites; ++i) {
      lans.push_back(make_wire("dds", time, log));
      brokers.push_back(make_wire("mqtt", time, log));
    }
    std::uint32_t id = 1;
    for (std::size_t site = 0; site < kSites; ++site) {
      for (const auto broker : {site, (site + 1) % kSites}) {
        for (int i = 0; i < 2; ++i) carriers.push_back({id++, site, broker, nullptr});
      }
    }
  }
  void start(Carrying& one) {
    one.process = std::make_unique<Site<>>(
        time, log, one.id, Site<>::On{{"dds", lans[one.site].get()}, {"mqtt", brokers[one.broker].get()}},
        rules_of({"*.lamp", "hall.**"}));
  }
  void join_members() {
    for (std::size_t i = 0; i < kSites; ++i) {
      robots.push_back(std::make_unique<Site<Home>>(time, log, robot(i), Site<Home>::On{{"dds", lans[i].get()}}));
      laptops.push_back(std::make_unique<Site<>>(time, log, 200 + i, Site<>::On{{"mqtt", brokers[i].get()}}));
    }
    for (std::size_t i = 0; i < kSites; ++i) {
      handles.push_back((*laptops[i])->space.subscribe(pattern("*:hall.lamp"), {}, [this, i](const Event& event) {
        if (event.kind != EventKind::kSet) return;
        ++arrived[i][number(event.tuple.owner)];
        last[i][number(event.tuple.owner)] = std::string(event.tuple.value);
      }));
    }
  }
  static std::uint32_t robot(std::size_t site) { return static_cast<std::uint32_t>(101 + site); }
  /// The sites that a broker is between.
  static std::array<std::size_t, 2> sites_of(std::size_t broker) { return {broker, (broker + kSites - 1) % kSites}; }

  /// Each robot says something new: every laptop within one step hears it once, and the others nothing.
  void expect_each_once(const std::string& value) {
    for (auto& one : arrived) one.clear();
    for (const auto& one : robots) EXPECT_TRUE((*one)->space.set("hall.lamp", value));
    time.run_for(5s);
    for (std::size_t broker = 0; broker < kSites; ++broker) {
      EXPECT_THAT(arrived[broker], SizeIs(2)) << "broker " << broker;
      for (const auto site : sites_of(broker)) {
        EXPECT_EQ(arrived[broker][robot(site)], 1) << value << ": robot of site " << site << " at broker " << broker;
        EXPECT_EQ(last[broker][robot(site)], value);
      }
    }
  }
  /// Of each pair of carriers that both live the first one carries.
  std::size_t working() const {
    return static_cast<std::size_t>(std::count_if(carriers.begin(), carriers.end(), [](const Carrying& one) {
      return one.process && one.process->stand_ins() > 0;
    }));
  }

  VirtualScheduler time;
  support::CollectingLog log;
  std::vector<std::unique_ptr<Wire>> lans, brokers;
  std::vector<Carrying> carriers;
  std::vector<std::unique_ptr<Site<Home>>> robots;
  std::vector<std::unique_ptr<Site<>>> laptops;
  std::array<std::map<std::uint32_t, int>, kSites> arrived;
  std::array<std::map<std::uint32_t, std::string>, kSites> last;
  std::vector<Handle> handles;
};

TEST_F(Ring, EachTupleArrivesOnce) {
  for (auto& one : carriers) start(one);
  join_members();
  time.run_for(30s);
  EXPECT_EQ(working(), 2 * kSites) << "one of two each";
  for (int round = 0; round < 5; ++round) expect_each_once(std::to_string(round));
}

TEST_F(Ring, WhateverOrderThingsStartIn) {
  join_members();
  for (const auto first : {11, 0, 7, 4, 2, 9, 1, 10, 3, 8, 5, 6}) {
    start(carriers[static_cast<std::size_t>(first)]);
    time.run_for(std::chrono::milliseconds(700 * (first % 4)));
  }
  time.run_for(60s);
  EXPECT_EQ(working(), 2 * kSites);
  expect_each_once("a");
}

/// Killed and started again, in an order that has no pattern; in between nothing arrives twice.
TEST_F(Ring, CarriersThatAreKilledAndStartedAgainRepeatNothing) {
  for (auto& one : carriers) start(one);
  join_members();
  time.run_for(30s);
  std::uint32_t chance = 12345;
  for (int round = 0; round < 30; ++round) {
    chance = chance * 1'664'525 + 1'013'904'223;
    auto& one = carriers[(chance >> 16) % carriers.size()];
    if (one.process) {
      if ((chance >> 8) % 2 == 0) one.process->kill();
      one.process.reset();
    } else {
      start(one);
    }
    for (auto& counts : arrived) counts.clear();
    for (const auto& robot : robots) ASSERT_TRUE((*robot)->space.set("hall.lamp", "r" + std::to_string(round)));
    time.run_for(std::chrono::milliseconds(500 + (chance >> 12) % 9000));
    for (std::size_t broker = 0; broker < kSites; ++broker) {
      for (const auto& [owner, times] : arrived[broker])
        EXPECT_LE(times, 1) << "round " << round << ": robot " << owner << " at broker " << broker;
    }
  }
  for (auto& one : carriers) {
    if (!one.process) start(one);
  }
  time.run_for(90s);
  EXPECT_EQ(working(), 2 * kSites);
  expect_each_once("end");
}

/// Commands too: the owner carries out each one once.
TEST_F(Ring, EachCommandIsCarriedOutOnce) {
  for (auto& one : carriers) start(one);
  join_members();
  time.run_for(30s);
  int applied = 0;
  for (std::size_t broker = 0; broker < kSites; ++broker) {
    for (const auto site : sites_of(broker)) {
      (*laptops[broker])
          ->space.set_remote(OwnerId(robot(site)), "hall.lamp", "b" + std::to_string(broker), 20s,
                             [&](const Reply& reply) { applied += reply.verdict == Verdict::kApplied ? 1 : 0; });
    }
  }
  time.run_for(20s);
  EXPECT_EQ(applied, 6);
  for (const auto& one : robots) EXPECT_THAT((*one)->sets, SizeIs(2));
}

}  // namespace
}  // namespace rubicon::tuples::carry
