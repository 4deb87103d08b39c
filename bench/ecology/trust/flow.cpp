#include <fmt/format.h>

#include "components/rounds.h"
#include "ecology/trust/measurements.h"
#include "ecology/trust/sides.h"

namespace rubicon::bench::trust {

namespace {

Json ping_once(const Plan& plan, const Meeting& meeting, bool paced) {
  auto answering = start_role("pong", meeting, Json::object());
  auto pinging = start_role("ping", meeting, {{"pace_us", paced ? 1000 : 0}, {"seconds", plan.seconds}});
  return result_of(pinging);
}

Json stream_once(const Plan& plan, const Meeting& meeting) {
  const std::size_t keys = 10'000;
  auto writing = start_role("writer", meeting, {{"keys", keys}, {"seconds", plan.seconds}, {"flat_out", false}});
  auto taking = start_role("sink", meeting, {{"keys", keys}, {"busy_us", 0}});
  const auto sink = result_of(taking), writer = result_of(writing);
  std::size_t lost = 0;
  for (std::size_t i = 0; i < keys; ++i) lost += writer.at("sequences")[i] != sink.at("sequences")[i];
  return {{"per_second", sink.at("per_second")},
          {"processor_us",
           writer.at("processor_us_per_set").get<double>() + sink.at("processor_us_per_tuple").get<double>()},
          {"lost", lost}};
}

std::uint64_t sum_of(const Json& rounds, const char* name) {
  std::uint64_t sum = 0;
  for (const auto& side : rounds) {
    for (const auto& round : side) sum += round.at(name).get<std::uint64_t>();
  }
  return sum;
}

}  // namespace

void measure_latency(const Plan& plan, Report& report) {
  Json figures, details;
  bool met = true;
  for (const bool paced : {false, true}) {
    const char* pace = paced ? "paced_1khz" : "tight";
    const auto sides =
        Sides::measured(plan, plan.rounds, [&](const Meeting& meeting) { return ping_once(plan, meeting, paced); });
    figures[pace] = {{"p50", sides.figure("p50", 1)}, {"p99", sides.figure("p99", 1)}};
    details[pace] = sides.rounds();
    met = met && sides.ratio("p50") <= 2.5;
  }
  report.figure("set_to_callback_us", figures);
  report.target("set_to_callback_us", "p50 at most 2.5 times that without trust", met);
  report.detail("set_to_callback_us", details);
}

void measure_throughput(const Plan& plan, Report& report) {
  const auto sides =
      Sides::measured(plan, plan.rounds, [&](const Meeting& meeting) { return stream_once(plan, meeting); });
  const auto lost = sum_of(sides.rounds(), "lost");
  report.figure("tuples_per_second", sides.figure("per_second", 0));
  report.figure("processor_us_per_tuple", sides.figure("processor_us", 2));
  report.figure("lost_final_states", lost);
  report.target("tuples_per_second", "at least 500000, and 0.3 times those without trust",
                sides.secure("per_second") >= 500'000 && sides.ratio("per_second") >= 0.3);
  report.target("lost_final_states", "0", lost == 0);
  report.detail("tuples_per_second", sides.rounds());
}

void measure_remote_sets(const Plan& plan, Report& report) {
  const std::uint64_t count = plan.is_quick ? 40'000 : 400'000;
  const auto sides =
      Sides::measured(plan, plan.rounds, [&](const Meeting& meeting) { return commands_round(meeting, count); });
  const auto faults = sum_of(sides.rounds(), "faults");
  report.figure("remote_sets_per_second", sides.figure("per_second", 0));
  report.figure("remote_set_faults", faults);
  report.target("remote_sets_per_second", "at least 200000", sides.secure("per_second") >= 200'000);
  report.target("remote_set_faults", "0", faults == 0);
  report.detail("remote_sets_per_second", sides.rounds());
}

}  // namespace rubicon::bench::trust
