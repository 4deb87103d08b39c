#include "components/rounds.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "components/roles.h"

namespace rubicon::bench {

double median_of(const std::vector<Json>& rounds, const char* name) {
  std::vector<double> values;
  for (const auto& round : rounds) values.push_back(round.at(name));
  return median(values);
}

Json stream_round(const Meeting& meeting, std::size_t keys, double seconds, int settle_ms) {
  auto writing = start_role("writer", meeting, {{"keys", keys}, {"seconds", seconds}, {"flat_out", false}});
  auto taking = start_role("sink", meeting, {{"keys", keys}, {"busy_us", 0}, {"settle_ms", settle_ms}});
  auto sink = result_of(taking), writer = result_of(writing);
  std::size_t stale = 0;
  for (std::size_t i = 0; i < keys; ++i) stale += writer.at("sequences")[i] != sink.at("sequences")[i];
  writer.erase("sequences");
  sink.erase("sequences");
  const auto lost = writer.at("sets").get<std::int64_t>() - writer.at("merged").get<std::int64_t>() -
                    sink.at("taken").get<std::int64_t>();
  return {{"writer", writer}, {"sink", sink}, {"lost", lost}, {"stale", stale}};
}

Json commands_round(const Meeting& meeting, std::uint64_t count) {
  auto owning = start_role("desk", meeting, {{"count", count}});
  auto commanding = start_role("commander", meeting, {{"count", count}});
  auto sent = result_of(commanding);
  const auto judged = result_of(owning);
  auto faults = sent.at("not_applied").get<std::uint64_t>();
  for (const auto* fault : {"lost", "twice", "out_of_order"}) faults += judged.at(fault).get<std::uint64_t>();
  sent["judged"] = judged;
  sent["faults"] = faults;
  return sent;
}

double end_round(const Meeting& meeting, int signal) {
  auto subscriber = start_role("watcher", meeting, Json::object());
  auto owner = start_role("watched", meeting, {{"watcher", subscriber.pid()}, {"signal", signal}});
  return result_of(owner).at("unwanted_s").get<double>();
}

void PingRounds::add(const Plan& plan, const Meeting& meeting, int pace_us) {
  const Json options{{"pace_us", pace_us}, {"seconds", plan.seconds}};
  {
    auto answering = start_role("bare-pong", meeting, Json::object());
    auto pinging = start_role("bare-ping", meeting, options);
    bare.push_back(result_of(pinging));
  }
  auto answering = start_role("pong", meeting, Json::object());
  auto pinging = start_role("ping", meeting, options);
  ours.push_back(result_of(pinging));
}

double PingRounds::ratio(const char* name) const {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < ours.size(); ++i)
    ratios.push_back(ours[i].at(name).get<double>() / bare[i].at(name).get<double>());
  return rounded(median(ratios), 2);
}

Json percentiles_of(const std::vector<Json>& rounds) {
  return {{"p50", rounded(median_of(rounds, "p50"), 1)}, {"p99", rounded(median_of(rounds, "p99"), 1)}};
}

std::vector<Child> start_crowd(const Meeting& meeting, int count, const CrowdTimes& times) {
  const auto begin = wall_seconds();
  std::vector<Child> all;
  all.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    all.push_back(start_role("one-of-many", meeting,
                             {{"number", i},
                              {"count", count},
                              {"begin", begin},
                              {"settled_s", times.settled},
                              {"idle_s", times.idle},
                              {"of_any_owner", times.of_any_owner}}));
  return all;
}

std::vector<Json> results_of(std::vector<Child>& children) {
  std::vector<Json> results;
  for (auto& one : children) results.push_back(result_of(one));
  return results;
}

double slowest_of(const std::vector<Json>& crowd) {
  double most = 0;
  for (const auto& one : crowd) {
    if (one.at("seen_s").get<double>() <= 0) return 0;
    most = std::max(most, one.at("seen_s").get<double>());
  }
  return most;
}

}  // namespace rubicon::bench
