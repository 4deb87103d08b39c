#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>

#include "tuples/mqtt/site.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

/// How a start ends.
enum class Ending : std::uint8_t {
  kLeft,
  kKilled,         ///< the broker publishes the will
  kUnplugged,      ///< the broker notices it after a while
  kWithTheBroker,  ///< killed together; the broker has its topics again, and no will
  kWithAForgetfulBroker,
};
constexpr Ending kEnds[]{Ending::kLeft, Ending::kKilled, Ending::kUnplugged, Ending::kWithTheBroker,
                         Ending::kWithAForgetfulBroker};

/// Two starts of one component, whose clock may go forward or back between them, at one broker.
struct Starts : testing::TestWithParam<std::tuple<bool, bool>> {
  Starts() {
    std::tie(options.watch_all, broker.speaks_5) = GetParam();
    options.lease = kMinLease;
    start(lab, kLab);
    start(hall, kHall);
  }
  /// `ahead`: of the right time, by its clock.
  void start(std::unique_ptr<Site>& place, OwnerId id, Duration ahead = {}) {
    const auto right = time.wall_now();
    time.set_wall(right + std::chrono::duration_cast<std::chrono::microseconds>(ahead));
    place = std::make_unique<Site>(time, net, id, fmt::format("10.0.1.{}", ++addresses), options);
    auto& [open, copies] = handles[id];
    open = place->space->add_policy(pattern("lamp"), [](const RemoteSet&) { return SetDecision::applied(); });
    copies = place->space->subscribe(pattern(id == kLab ? "1:**" : "2:**"), {}, [](const Event&) {});
    EXPECT_TRUE(place->space->set("lamp", "off"));
    EXPECT_TRUE(place->space->set("start", std::to_string(addresses)));
    time.set_wall(right);
  }
  std::string client_of(OwnerId id) const {
    const auto& all = broker.published();
    const auto last = std::find_if(all.rbegin(), all.rend(), [&](const auto& one) {
      return one.topic.ends_with("/" + std::to_string(number(id))) && !one.payload.empty();
    });
    return last == all.rend() ? "" : last->client;
  }
  void finish(std::unique_ptr<Site>& place, OwnerId id, Ending how) {
    const auto saved = broker.retained();
    if (how == Ending::kKilled) broker.cut(client_of(id));
    if (how == Ending::kUnplugged) broker.stall(client_of(id), true);
    if (how == Ending::kWithTheBroker) broker.stop(true);
    if (how == Ending::kWithAForgetfulBroker) broker.stop(false);
    handles[id] = {};
    place.reset();
    if (how == Ending::kWithTheBroker) broker.restart(saved);
    if (how == Ending::kWithAForgetfulBroker) broker.start();
  }
  /// A set with a reply, and the copies of the other one.
  std::string faults_of(Site& from, OwnerId owner, Site& other) {
    std::string faults;
    if (from.value(owner, "start") != other.value(owner, "start"))
      faults += fmt::format("start of {} is {} not {}; ", number(owner), from.value(owner, "start"),
                            other.value(owner, "start"));
    std::optional<Verdict> verdict;
    from.space->set_remote(owner, "lamp", "on", 5s, [&](const Reply& reply) { verdict = reply.verdict; });
    time.run_for(6s);
    if (verdict != Verdict::kApplied)
      faults += fmt::format("a set of {} is {}; ", number(owner), to_string(verdict.value_or(Verdict::kRefused)));
    if (!other.space->has_subscriber(*other.space->find("lamp")))
      faults += fmt::format("{} has no subscriber; ", number(owner));
    return faults;
  }
  std::string faults() { return faults_of(*lab, kHall, *hall) + faults_of(*hall, kLab, *lab); }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, kBroker};
  SpaceOptions options = options_at({kBroker});
  std::map<OwnerId, std::pair<Handle, Handle>> handles;
  std::unique_ptr<Site> hall, lab;
  int addresses = 0;
};

TEST_P(Starts, AreFollowedWhateverTheirClockSays) {
  time.run_for(5s);
  for (const auto how : kEnds) {
    for (const auto clock : {0h, 24h, 0h, -24h, 0h, 1h}) {
      for (const auto pause : {Duration(0), Duration(1s), Duration(20s)}) {
        finish(hall, kHall, how);
        time.run_for(pause);
        start(hall, kHall, clock);
        time.run_for(75s);
        EXPECT_EQ(faults(), "") << static_cast<int>(how) << " clock " << clock / 1h << " h, after " << pause / 1s
                                << " s";
        EXPECT_THAT(hall->displaced, IsEmpty());
      }
    }
  }
}

/// As when all of a house is switched on again.
TEST_P(Starts, OfBothAtOnceAreFollowed) {
  time.run_for(5s);
  for (const auto how : kEnds) {
    for (const auto clock : {24h, 0h}) {
      finish(hall, kHall, how);
      finish(lab, kLab, how);
      start(lab, kLab, clock);
      start(hall, kHall, clock);
      time.run_for(75s);
      EXPECT_EQ(faults(), "") << static_cast<int>(how) << " clock " << clock / 1h << " h";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AtABroker, Starts, testing::Combine(testing::Bool(), testing::Bool()), [](const auto& one) {
  return std::string(std::get<0>(one.param) ? "OfAll" : "OfThoseWhoDeal") + (std::get<1>(one.param) ? "By5" : "By311");
});

}  // namespace
}  // namespace rubicon::tuples::mqtt
