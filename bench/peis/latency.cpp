#include "components/roles.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

namespace {

/// Half round trips of our tuples and of the same bytes on a bare connection, at one pace.
struct Pair {
  std::vector<Json> ours, bare;

  void add(const Plan& plan, int pace_us) {
    const Json options{{"pace_us", pace_us}, {"seconds", plan.seconds}};
    const auto meeting = plan.new_meeting();
    {
      auto answering = start_role("bare-pong", meeting, Json::object());
      auto pinging = start_role("bare-ping", meeting, options);
      bare.push_back(result_of(pinging));
    }
    auto answering = start_role("pong", meeting, Json::object());
    auto pinging = start_role("ping", meeting, options);
    ours.push_back(result_of(pinging));
  }
  /// Of each round, because the load of the machine changes between them.
  double ratio(const char* name) const {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < ours.size(); ++i)
      ratios.push_back(ours[i].at(name).get<double>() / bare[i].at(name).get<double>());
    return rounded(median(ratios), 2);
  }
};

Json percentiles(const std::vector<Json>& rounds) {
  return {{"p50", rounded(median_of(rounds, "p50"), 1)}, {"p99", rounded(median_of(rounds, "p99"), 1)}};
}

}  // namespace

void measure_latency(const Plan& plan, Report& report) {
  Json ours, bare, ratios, rounds;
  bool met = true;
  for (const auto& [name, pace_us] : {std::pair("tight", 0), std::pair("paced_1khz", 1000)}) {
    Pair pair;
    for (int round = 0; round < plan.rounds; ++round) pair.add(plan, pace_us);
    ours[name] = percentiles(pair.ours);
    bare[name] = percentiles(pair.bare);
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
