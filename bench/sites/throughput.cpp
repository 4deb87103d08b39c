#include <cmath>
#include <utility>

#include "components/rounds.h"
#include "sites/broker.h"
#include "sites/measurements.h"

namespace rubicon::bench::sites {

namespace {

constexpr std::size_t kStreamKeys = 1000;
constexpr int kSettleMs = 1000;

/// With the processor time of the broker for each value.
Json broker_round(const Plan& plan, const Broker& broker) {
  const auto before = broker.processor();
  auto round = stream_round(broker.new_meeting(plan), kStreamKeys, plan.seconds, kSettleMs);
  const auto used = broker.processor() - before;
  round["per_second"] = round.at("sink").at("per_second");
  round["broker_us"] = used / round.at("sink").at("taken").get<double>() * 1e6;
  round["broker_percent"] = used / plan.seconds * 100;
  return round;
}

}  // namespace

void measure_throughput(const Plan& plan, Report& report) {
  Json rates, stale, costs, shares, all;
  bool met = true, complete = true;
  for (const auto& [what, secure] : {std::pair("plain", false), std::pair("tls", true)}) {
    const Broker broker(plan, report, "throughput", secure);
    if (!broker) return;
    std::vector<Json> rounds;
    std::uint64_t wrong = 0;
    for (int round = 0; round < plan.rounds; ++round) {
      rounds.push_back(broker_round(plan, broker));
      wrong += rounds.back().at("stale").get<std::uint64_t>();
    }
    rates[what] = std::round(median_of(rounds, "per_second"));
    costs[what] = rounded(median_of(rounds, "broker_us"), 3);
    shares[what] = rounded(median_of(rounds, "broker_percent"), 1);
    stale[what] = wrong;
    all[what] = rounds;
    met = met && rates[what] >= 200'000;
    complete = complete && wrong == 0;
  }
  report.figure("tuples_per_second", rates);
  report.figure("stale_copies", stale);
  report.figure("broker_us_per_tuple", costs);
  report.figure("broker_percent_of_a_processor", shares);
  report.target("tuples_per_second", "at least 200000", met);
  report.target("stale_copies", "0", complete);
  report.detail("tuples_per_second",
                {{"method",
                  "callbacks a second of one subscriber, all 1000 tuples of one writer set over and over in turns of "
                  "1000, 64-byte values, the writer waiting while 5000 changes wait; stale: copies that are not the "
                  "owner's a second after the last set"},
                 {"rounds", all}});
}

}  // namespace rubicon::bench::sites
