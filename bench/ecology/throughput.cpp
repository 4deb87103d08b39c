#include <cmath>

#include "components/roles.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

struct Run {
  Json writer, sink;
  std::size_t lost = 0;
};

Run run_once(const Plan& plan, bool slow) {
  const std::size_t keys = 10'000;
  const auto meeting = plan.new_meeting();
  auto writing = start_role("writer", meeting, {{"keys", keys}, {"seconds", plan.seconds}, {"flat_out", slow}});
  auto taking = start_role("sink", meeting, {{"keys", keys}, {"busy_us", slow ? 20 : 0}});
  Run run;
  run.sink = result_of(taking);
  run.writer = result_of(writing);
  const auto &left = run.writer.at("sequences"), &right = run.sink.at("sequences");
  for (std::size_t i = 0; i < keys; ++i) run.lost += left[i] != right[i];
  run.writer.erase("sequences");
  run.sink.erase("sequences");
  return run;
}

Json json_of(const Run& run) {
  return {{"writer", run.writer}, {"sink", run.sink}, {"lost_final_states", run.lost}};
}

}  // namespace

void measure_throughput(const Plan& plan, Report& report) {
  std::vector<double> rates;
  Json rounds = Json::array();
  std::size_t lost = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto run = run_once(plan, false);
    rates.push_back(run.sink.at("per_second"));
    lost += run.lost;
    rounds.push_back(json_of(run));
  }
  const auto slow = run_once(plan, true);
  lost += slow.lost;
  const auto rate = std::round(median(rates));
  const double grown = slow.writer.at("grown_mb");
  report.figure("tuples_per_second", rate);
  report.figure("lost_final_states", lost);
  report.figure("merged", slow.writer.at("merged"));
  report.figure("owner_mb_slow_subscriber", grown);
  report.target("tuples_per_second", "at least 500000", rate >= 500'000);
  report.target("lost_final_states", "0", lost == 0);
  report.target("owner_mb_slow_subscriber", "bounded: at most 20", grown <= 20);
  report.detail("tuples_per_second",
                {{"method",
                  "callbacks a second of one subscriber, all 10000 tuples of one writer set over and over in turns of "
                  "1000, 64-byte values, the writer waiting while 5000 changes wait; slow: a writer that never waits "
                  "and a subscriber that sleeps at each tuple"},
                 {"rounds", rounds},
                 {"slow_subscriber", json_of(slow)}});
}

}  // namespace rubicon::bench
