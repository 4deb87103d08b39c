#include <csignal>
#include <thread>

#include "components/rounds.h"
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
  if (result.at("stale") != 0) give_up("a subscriber that was stopped never has the last values");
  (void)result_of(owner);
  return result.at("complete").get<double>() - back;
}

}  // namespace

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
    for (int round = 0; round < plan.rounds; ++round)
      rounds.push_back(rounded(end_round(plan.new_meeting(), signal), 3));
    const auto most = percentile(rounds, 1);
    report.figure(name, most);
    report.target(name, "under the lease and 0.5", most < kLease + 0.5);
    report.detail(name, {{"method", "from the signal to the end of demand at the owner; the slowest round"},
                         {"lease_s", kLease},
                         {"rounds", rounds}});
  }
}

}  // namespace rubicon::bench::peis
