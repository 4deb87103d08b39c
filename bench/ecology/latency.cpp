#include <fmt/format.h>
#include <sched.h>

#include <array>
#include <map>
#include <regex>

#include "components/roles.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

/// Where the two processes run: what stands before their commands.
struct Place {
  const char* name;
  std::vector<std::string> first, second;
};

/// The scheduler of Linux runs two processes that wake each other on one CPU or on two, for seconds at a time; that
/// alone makes a half round trip of either tool take 10 us or 40 us. On fixed CPUs both tools have the same conditions.
std::vector<Place> places() {
  std::vector<Place> all{{"free", {}, {}}};
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  std::vector<std::string> names;
  if (::sched_getaffinity(0, sizeof allowed, &allowed) != 0) return all;
  for (std::size_t i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(i, &allowed)) names.push_back(std::to_string(i));
  }
  if (names.size() < 2) return all;
  all.push_back({"apart", {"taskset", "-c", names[0]}, {"taskset", "-c", names[1]}});
  return all;
}

/// `ddsperf` for comparison, on loopback too, in listener mode, which is its default.
Json engine_ping(const Plan& plan, const Place& place, bool paced) {
  const auto config = "CYCLONEDDS_URI=" + tuples::dds::domain_xml(options_of(plan.new_meeting()));
  const auto seconds = std::to_string(static_cast<int>(plan.seconds) + 2);
  auto other = place.second, command = place.first;
  for (auto* one : {&other, &command})
    one->insert(one->end(), {"ddsperf", "-i", std::to_string(plan.domain), "-X", "-D", seconds});
  other.emplace_back("pong");
  command.emplace_back("ping");
  if (paced) command.emplace_back("1000Hz");
  command.insert(command.end(), {"size", "64"});
  Child answering(other, {config}), pinging(command, {config});
  const auto text = pinging.output(std::chrono::seconds(60));
  static const std::regex kLine(R"re(size 64 mean .* 50% ([0-9.]+)us .* 99% ([0-9.]+)us)re");
  std::vector<double> p50, p99;
  for (std::sregex_iterator it(text.begin(), text.end(), kLine), end; it != end; ++it) {
    p50.push_back(std::stod((*it)[1]));
    p99.push_back(std::stod((*it)[2]));
  }
  if (p50.empty()) give_up("ddsperf says no percentiles: " + text);
  if (p50.size() > 1) p50.erase(p50.begin()), p99.erase(p99.begin());  // warming up
  return {{"p50", median(p50)}, {"p99", median(p99)}};
}

/// A Unix stream between two processes that do nothing else.
Json bare_stream(const Plan& plan, const Place& place, bool paced) {
  const auto meeting = plan.new_meeting();
  auto answering = start_role("bare-pong", meeting, Json::object(), place.second);
  auto pinging =
      start_role("bare-ping", meeting, {{"pace_us", paced ? 1000 : 0}, {"seconds", plan.seconds}}, place.first);
  return result_of(pinging);
}

/// What the engine is measured against.
Json floor_of(const Plan& plan, const Place& place, bool paced) {
  return plan.engine == "host" ? bare_stream(plan, place, paced) : engine_ping(plan, place, paced);
}

Json our_ping(const Plan& plan, const Place& place, bool paced) {
  const auto meeting = plan.new_meeting();
  auto answering = start_role("pong", meeting, Json::object(), place.second);
  auto pinging = start_role("ping", meeting, {{"pace_us", paced ? 1000 : 0}, {"seconds", plan.seconds}}, place.first);
  return result_of(pinging);
}

/// Medians over the rounds.
Json middle(const std::vector<Json>& rounds) {
  std::vector<double> p50, p99;
  for (const auto& round : rounds) {
    p50.push_back(round.at("p50"));
    p99.push_back(round.at("p99"));
  }
  return {{"p50", rounded(median(p50), 1)}, {"p99", rounded(median(p99), 1)}};
}

double ratio(const Json& ours, const Json& engine, const char* name) {
  return rounded(ours.at(name).get<double>() / engine.at(name).get<double>(), 2);
}

/// Both at one pace in one place.
struct Pair {
  std::vector<Json> ours, engine;

  Json ratios() const {
    return {{"p50", ratio(middle(ours), middle(engine), "p50")}, {"p99", ratio(middle(ours), middle(engine), "p99")}};
  }
  bool met() const { return ratios().at("p50").get<double>() <= 2 && ratios().at("p99").get<double>() <= 3; }
  Json json() const {
    return {{"set_to_callback_us", middle(ours)},
            {"engine_ping_us", middle(engine)},
            {"ratios", ratios()},
            {"met", met()},
            {"rounds", {{"set_to_callback_us", ours}, {"engine_ping_us", engine}}}};
  }
};

constexpr const char* kPaces[] = {"tight", "paced_1khz"};

}  // namespace

void measure_latency(const Plan& plan, Report& report) {
  const auto where = places();
  std::map<std::string, std::array<Pair, 2>> pairs;
  for (int round = 0; round < plan.rounds; ++round) {
    for (const auto& place : where) {
      for (const bool paced : {false, true}) {
        auto& pair = pairs[place.name][paced];
        pair.engine.push_back(floor_of(plan, place, paced));
        pair.ours.push_back(our_ping(plan, place, paced));
      }
    }
  }
  Json ours, engine, details;
  const std::string told = where.front().name;  // free: as a user runs them
  bool met = true;
  for (const bool paced : {false, true}) {
    const auto& pair = pairs[told][paced];
    ours[kPaces[paced]] = middle(pair.ours);
    engine[kPaces[paced]] = middle(pair.engine);
    met = met && pair.met();
    for (const auto& place : where) details[place.name][kPaces[paced]] = pairs[place.name][paced].json();
  }
  report.figure("set_to_callback_us", ours);
  report.figure("engine_ping_us", engine);
  report.target("set_to_callback_us", "p50 at most 2 times, p99 at most 3 times engine_ping_us", met);
  details["told"] = told;
  details["method"] =
      "half of: set by one process, callback in the other, which sets its answer, callback in the first; 64-byte "
      "values; percentiles of each second as ddsperf -X has them, median of seconds and rounds; apart: each process on "
      "a processor of its own, free: wherever the scheduler puts them; the same for ddsperf, and on engine host for a "
      "bare Unix stream";
  report.detail("set_to_callback_us", details);
}

}  // namespace rubicon::bench
