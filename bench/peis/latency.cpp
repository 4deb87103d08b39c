#include "components/rounds.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

void measure_latency(const Plan& plan, Report& report) {
  Json ours, bare, ratios, rounds;
  bool met = true;
  for (const auto& [name, pace_us] : {std::pair("tight", 0), std::pair("paced_1khz", 1000)}) {
    PingRounds pair;
    for (int round = 0; round < plan.rounds; ++round) pair.add(plan, plan.new_meeting(), pace_us);
    ours[name] = percentiles_of(pair.ours);
    bare[name] = percentiles_of(pair.bare);
    ratios[name] = {{"p50", pair.ratio("p50")}, {"p99", pair.ratio("p99")}};
    rounds[name] = {{"set_to_callback_us", pair.ours}, {"bare_us", pair.bare}};
    met = met && pair.ratio("p50") <= 3;
  }
  report.figure("set_to_callback_us", ours);
  report.figure("bare_ping_us", bare);
  report.figure("latency_ratio", ratios);
  report.target("set_to_callback_us", "p50 at most 3 times bare_ping_us", met);
  report.detail("set_to_callback_us",
                {{"method",
                  "half of: set by one process, callback in the other, which sets its answer, callback in the first; "
                  "64-byte values; bare: as many bytes there and back on a TCP connection in blocking calls, right "
                  "before; ratios are medians of the ratios of rounds"},
                 {"bytes", bytes_of_push()},
                 {"rounds", rounds}});
}

}  // namespace rubicon::bench::peis
