#include <utility>

#include "components/rounds.h"
#include "sites/broker.h"
#include "sites/measurements.h"

namespace rubicon::bench::sites {

void measure_latency(const Plan& plan, Report& report) {
  Json ours, bare, ratios, rounds;
  bool met = true;
  for (const auto& [what, secure] : {std::pair("plain", false), std::pair("tls", true)}) {
    const Broker broker(plan, report, "latency", secure);
    if (!broker) return;
    for (const auto& [pace, pace_us] : {std::pair("tight", 0), std::pair("paced_1khz", 1000)}) {
      PingRounds pings;
      for (int round = 0; round < plan.rounds; ++round) pings.add(plan, broker.new_meeting(plan), pace_us);
      ours[what][pace] = percentiles_of(pings.ours);
      bare[what][pace] = percentiles_of(pings.bare);
      ratios[what][pace] = {{"p50", pings.ratio("p50")}, {"p99", pings.ratio("p99")}};
      rounds[what][pace] = {{"set_to_callback_us", pings.ours}, {"bare_us", pings.bare}};
      met = met && pings.ratio("p50") <= 2;
    }
  }
  report.figure("set_to_callback_us", ours);
  report.figure("bare_ping_us", bare);
  report.figure("latency_ratio", ratios);
  report.target("set_to_callback_us", "p50 at most 2 times bare_ping_us", met);
  report.detail("set_to_callback_us",
                {{"method",
                  "half of: set by one process, callback in the other, which sets its answer, callback in the first; "
                  "64-byte values; bare: half of the round trip of as many bytes between two clients of libmosquitto, "
                  "QoS 0, right before; ratios are medians of the ratios of rounds"},
                 {"rounds", rounds}});
}

}  // namespace rubicon::bench::sites
