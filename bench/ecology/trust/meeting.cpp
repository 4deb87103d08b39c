#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <tuple>

#include "ecology/trust/measurements.h"
#include "ecology/trust/sides.h"

namespace rubicon::bench::trust {

namespace {

constexpr const char* kKey = "bench.shelf";
constexpr int kTuples = 1000;
constexpr double kSettled = 8, kSettledMany = 110;

Json meet_once(const Meeting& meeting) {
  auto staying = start_role("stayer", meeting, Json::object());
  auto coming = start_role("newcomer", meeting, Json::object());
  (void)result_of(coming);  // it may have waited for the start of the other
  auto coming_again = start_role("newcomer", meeting, Json::object());
  return result_of(coming_again);
}

/// From the start of the tool to its end.
double seconds_of_get(const Meeting& meeting, const std::string& target) {
  const auto start = std::chrono::steady_clock::now();
  Child tool({RUBICON_BINARY_DIR "/bin/rubicon", "get", target, "--domain", std::to_string(meeting.domain), "--tag",
              meeting.tag, "--trust", meeting.trust.empty() ? "no" : meeting.trust},
             {});
  const auto text = tool.output(std::chrono::seconds(30));
  if (number_of(text) != 1) give_up("rubicon get says: " + text);
  return seconds_between(start, std::chrono::steady_clock::now());
}

Json get_once(const Meeting& meeting) {
  auto staying = start_role("stayer", meeting, Json::object());
  auto coming = start_role("newcomer", meeting, Json::object());
  (void)result_of(coming);  // so that the other is there
  return {{"seconds", seconds_of_get(meeting, kKey)},
          {"seconds_of_named_owner", seconds_of_get(meeting, fmt::format("{}:{}", number(kFirst), kKey))}};
}

Json crowd_once(const Meeting& meeting, int count) {
  const auto begin = wall_seconds();
  const double settled = count > 20 ? kSettledMany : kSettled;
  std::vector<Child> all;
  for (int i = 0; i < count; ++i)
    all.push_back(
        start_role("one-of-many", meeting,
                   {{"number", i}, {"count", count}, {"begin", begin}, {"settled_s", settled}, {"idle_s", 1}}));
  double slowest = 0;
  int unseen = 0, lost = 0;
  for (auto& one : all) {
    const auto result = result_of(one);
    const double seen = result.at("seen_s");
    unseen += seen == 0;
    lost += result.at("lost_peers").get<int>();
    slowest = std::max(slowest, seen);
  }
  return {{"seconds", unseen == 0 ? slowest : settled}, {"members_that_did_not_see_all", unseen}, {"lost_peers", lost}};
}

}  // namespace

/// Stays until it is ended.
Json stayer(const Meeting& meeting, const Json&) {
  Node node(kFirst, meeting);
  (void)node.space().set(kKey, value_of(1));
  for (int i = 0; i < kTuples; ++i)
    (void)node.space().set(fmt::format("bench.hall.sensor.light-{}.value", i), value_of(1));
  node.rest(std::chrono::minutes(2));
  return Json::object();
}

Json newcomer(const Meeting& meeting, const Json& options) {
  const auto start = std::chrono::steady_clock::now();
  Node node(kSecond, meeting);
  const auto joined = std::chrono::steady_clock::now();
  node.await(kFirst);
  const auto met = std::chrono::steady_clock::now();
  const auto all = node.space().subscribe({kFirst, "bench.**"}, {}, [](const tuples::Event&) {});
  node.rest(options.value("stays", false) ? std::chrono::milliseconds(2000) : std::chrono::milliseconds(50));
  return {{"seconds", seconds_between(joined, met)},
          {"with_start_of_engine", seconds_between(start, met)},
          {"resident_mb", resident_mb()},
          {"private_mb", private_mb()}};
}

void measure_meeting(const Plan& plan, Report& report) {
  const auto sides = Sides::measured(plan, plan.rounds, meet_once);
  report.figure("meeting_s", sides.figure("seconds", 3));
  report.figure("meeting_with_start_of_engine_s", sides.figure("with_start_of_engine", 3));
  report.target("meeting_s", "at most 0.5", sides.secure("seconds") <= 0.5);
  report.detail("meeting_s", sides.rounds());
}

void measure_memory(const Plan& plan, Report& report) {
  const auto sides = Sides::measured(plan, plan.is_quick ? 1 : 3, [](const Meeting& meeting) {
    auto staying = start_role("stayer", meeting, Json::object());
    auto coming = start_role("newcomer", meeting, {{"stays", true}});
    return result_of(coming);
  });
  const auto more = [&](const char* name) { return rounded(sides.secure(name) - sides.plain(name), 1); };
  report.figure("resident_mb", sides.figure("resident_mb", 1));
  report.figure("private_mb", sides.figure("private_mb", 1));
  report.figure("resident_mb_of_trust", more("resident_mb"));
  report.figure("private_mb_of_trust", more("private_mb"));
  report.target("resident_mb_of_trust", "at most 4", more("resident_mb") <= 4);
  report.detail("resident_mb", sides.rounds());
}

void measure_get(const Plan& plan, Report& report) {
  const auto sides = Sides::measured(plan, plan.rounds, get_once);
  report.figure("get_s", sides.figure("seconds", 2));
  report.figure("get_of_named_owner_s", sides.figure("seconds_of_named_owner", 2));
  report.target("get_s", "below 1", sides.secure("seconds") < 1);
  report.detail("get_s", sides.rounds());
}

void measure_crowd(const Plan& plan, Report& report) {
  const auto measured = [&](int count, int rounds) {
    const auto sides =
        Sides::measured(plan, rounds, [count](const Meeting& meeting) { return crowd_once(meeting, count); });
    report.figure(fmt::format("{}_members_meet_s", count), sides.figure("seconds", 2));
    report.detail(fmt::format("{}_members_meet_s", count), sides.rounds());
    return sides.secure("seconds");
  };
  const auto seconds = measured(plan.is_quick ? 5 : 20, plan.is_quick ? 1 : 3);
  report.target("20_members_meet_s", "at most 5", seconds <= 5);
  if (!plan.is_quick) std::ignore = measured(50, 1);
}

}  // namespace rubicon::bench::trust
