#include <csignal>
#include <thread>

#include "peis/measurements.h"

namespace rubicon::bench::peis {

namespace {

constexpr double kLease = 2;  // of PeisOptions

void sleep_seconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Seconds from the return of a subscriber that was stopped to its last right value.
double stall_once(const Plan& plan, double stalled) {
  constexpr std::uint64_t kKeys = 1000, kPerSecond = 5000;
  const auto meeting = plan.new_meeting();
  const double writing = stalled - 0.5;
  const auto sets = static_cast<std::uint64_t>(kPerSecond * writing);
  auto owner = start_role("paced-writer", meeting, {{"keys", kKeys}, {"per_second", kPerSecond}, {"seconds", writing}});
  auto subscriber = start_role("follower", meeting, {{"keys", kKeys}, {"sets", sets}});
  sleep_seconds(2);
  subscriber.signal(SIGSTOP);
  sleep_seconds(stalled);
  const auto back = wall_seconds();
  subscriber.signal(SIGCONT);
  const auto result = result_of(subscriber);
  (void)result_of(owner);
  return result.at("complete").get<double>() - back;
}

/// Seconds from the end of a subscriber to its owner's knowledge of it.
double end_once(const Plan& plan, int signal) {
  const auto meeting = plan.new_meeting();
  auto owner = start_role("watched", meeting, Json::object());
  auto subscriber = start_role("watcher", meeting, Json::object());
  sleep_seconds(2);
  const auto end = wall_seconds();
  subscriber.signal(signal);
  return result_of(owner).at("unwanted").get<double>() - end;
}

}  // namespace

/// The owner of a tuple until the demand for it ended.
Json watched(const Meeting& meeting, const Json&) {
  Node node(kFirst, meeting);
  (void)node.space().set(key_of(0), value_of(0));
  bool wanted = false;
  const auto demand = node.space().watch_demand({kFirst, key_of(0)}, [&](const tuples::Demand& now) {
    if (wanted && !now.wanted) node.finish();
    wanted = now.wanted;
  });
  node.run(std::chrono::minutes(2));
  return {{"unwanted", wall_seconds()}};
}

Json watcher(const Meeting& meeting, const Json&) {
  Node node(kSecond, meeting);
  const auto all = node.space().subscribe({kFirst, "**"}, {}, [](const tuples::Event&) {});
  node.run(std::chrono::minutes(2));
  return Json::object();
}

void measure_stall(const Plan& plan, Report& report) {
  const double stalled = plan.is_quick ? 4 : 60;
  std::vector<double> rounds;
  for (int round = 0; round < (plan.rounds + 1) / 2; ++round) rounds.push_back(rounded(stall_once(plan, stalled), 3));
  const auto most = percentile(rounds, 1);
  report.figure("right_after_stall_s", most);
  report.target("right_after_stall_s", "under 1", most < 1);
  report.detail("right_after_stall_s",
                {{"method",
                  "subscriber of 1000 tuples that are set 5000 times a second, stopped (SIGSTOP) for stalled_s; from "
                  "its return to the moment when it has the last value of all; the slowest round"},
                 {"stalled_s", stalled},
                 {"rounds", rounds}});
}

void measure_death(const Plan& plan, Report& report) {
  for (const auto& [name, signal] :
       {std::pair("owner_learns_of_killed_s", SIGKILL), std::pair("owner_learns_of_stopped_s", SIGSTOP)}) {
    std::vector<double> rounds;
    for (int round = 0; round < plan.rounds; ++round) rounds.push_back(rounded(end_once(plan, signal), 3));
    const auto most = percentile(rounds, 1);
    report.figure(name, most);
    report.target(name, "under the lease and 0.5", most < kLease + 0.5);
    report.detail(name, {{"method", "from the signal to the end of demand at the owner; the slowest round"},
                         {"lease_s", kLease},
                         {"rounds", rounds}});
  }
}

}  // namespace rubicon::bench::peis
