#include <cmath>

#include "components/rounds.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

namespace {

constexpr std::size_t kFlowKeys = 10'000;

Json run_bare(const Plan& plan) {
  const auto meeting = plan.new_meeting();
  auto taking = start_role("bare-sink", meeting, Json::object());
  auto giving = start_role("bare-source", meeting, {{"seconds", plan.seconds}});
  const auto source = result_of(giving);
  auto sink = result_of(taking);
  const double us = 1e6 / sink.at("count").get<double>();
  return {{"per_second", sink.at("per_second")},
          {"processor_us", {source.at("processor_s").get<double>() * us, sink.at("processor_s").get<double>() * us}}};
}

}  // namespace

void measure_throughput(const Plan& plan, Report& report) {
  std::vector<double> rates, costs, bare_rates;
  Json rounds = Json::array();
  std::int64_t lost = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto bare = run_bare(plan), engine = stream_round(plan.new_meeting(), kFlowKeys, plan.seconds);
    bare_rates.push_back(bare.at("per_second"));
    rates.push_back(engine.at("sink").at("per_second"));
    costs.push_back(engine.at("writer").at("processor_us_per_set").get<double>() +
                    engine.at("sink").at("processor_us_per_tuple").get<double>());
    lost += engine.at("lost").get<std::int64_t>() + engine.at("stale").get<std::int64_t>();
    rounds.push_back({{"engine", engine}, {"bare", bare}});
  }
  const auto rate = std::round(median(rates));
  report.figure("tuples_per_second", rate);
  report.figure("bare_per_second", std::round(median(bare_rates)));
  report.figure("processor_us_per_tuple", rounded(median(costs), 2));
  report.figure("lost_tuples", lost);
  report.target("tuples_per_second", "at least 200000", rate >= 200'000);
  report.target("lost_tuples", "0", lost == 0);
  report.detail("tuples_per_second",
                {{"method",
                  "callbacks a second of one subscriber, all 10000 tuples of one writer set over and over in turns of "
                  "1000, 64-byte values, the writer waiting while 5000 changes wait; lost: sets that were neither "
                  "merged nor delivered, and tuples that end with another value; bare: as many bytes for each through "
                  "one TCP connection in blocks of 32 KiB; processor time of both processes"},
                 {"rounds", rounds}});
}

}  // namespace rubicon::bench::peis
