#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "components/rounds.h"
#include "sites/broker.h"
#include "sites/measurements.h"

namespace rubicon::bench::sites {

namespace {

constexpr OwnerId kDesk{1'070'003}, kCommander{1'070'004};
constexpr const char* kLamp = "bench.desk.lamp-1.command";
constexpr double kLives = 2;  // seconds, of a command
constexpr std::uint64_t kStreamRate = 5000, kCommandRate = 100;
constexpr std::size_t kStreamTuples = 1000;

void sleep_for_seconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

Duration in_seconds(const Json& seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds.get<double>()));
}

/// Commands at an even pace, each with a number and the time when it was sent.
class SteadyCommands {
 public:
  SteadyCommands(Node& node, Duration span) : node_(node), end_(node.scheduler().now() + span) { next(); }
  Json json() const { return {{"sent", number_}, {"verdicts", verdicts_}, {"applied", applied_}}; }

 private:
  void next() {
    if (node_.scheduler().now() >= end_) return;
    const auto number = ++number_;
    node_.space().set_remote(kDesk, kLamp, fmt::format("{} {:.6f}", number, wall_seconds()), in_seconds(kLives),
                             [this, number](const tuples::Reply& reply) {
                               if (reply.verdict == tuples::Verdict::kApplied) applied_.insert(number);
                               ++verdicts_[std::string(tuples::to_string(reply.verdict))];
                             });
    timer_ = node_.scheduler().after(in_seconds(1.0 / kCommandRate), [this] { next(); });
  }

  Node& node_;
  SteadyTime end_;
  std::uint64_t number_ = 0;
  std::set<std::uint64_t> applied_;
  std::map<std::string, int> verdicts_;
  base::Timer timer_;
};

/// Seconds from each end of the broker to the next value.
std::vector<double> pauses_after(const std::vector<double>& ends, const Json& pauses) {
  std::vector<double> all;
  for (const auto end : ends) {
    double longest = 0;
    for (const auto& pause : pauses) {
      const double from = pause[0], to = pause[1];
      if (to > end && from < end + 1) longest = std::max(longest, to - end);
    }
    all.push_back(rounded(longest, 3));
  }
  return all;
}

int never_executed(const Json& applied, const Json& executed) {
  const auto done = executed.get<std::set<std::uint64_t>>();
  return static_cast<int>(std::count_if(applied.begin(), applied.end(),
                                        [&](const Json& one) { return !done.contains(one.get<std::uint64_t>()); }));
}

struct Load {
  Json stream, commands, desk;
  std::vector<double> ends;  ///< of the broker
};

Load load_while_it_restarts(const Plan& plan, Broker& broker, int restarts) {
  const double apart = plan.is_quick ? 1.5 : 3, seconds = restarts * apart + 4;
  const auto sets = static_cast<std::uint64_t>(seconds) * kStreamRate;
  const auto meeting = broker.new_meeting(plan);
  auto desk = start_role("steady-desk", meeting, {{"seconds", seconds + 8}});
  auto writer = start_role(
      "paced-writer", meeting,
      {{"keys", kStreamTuples}, {"per_second", kStreamRate}, {"seconds", static_cast<std::uint64_t>(seconds)}});
  auto reader = start_role("follower", meeting,
                           {{"keys", kStreamTuples}, {"sets", sets}, {"patience_s", static_cast<int>(seconds) + 20}});
  auto commander = start_role("steady-commander", meeting, {{"seconds", seconds}});
  Load load;
  sleep_for_seconds(3);
  for (int i = 0; i < restarts; ++i) {
    load.ends.push_back(wall_seconds());
    broker.restart();
    sleep_for_seconds(apart);
  }
  load.stream = result_of(reader);
  (void)result_of(writer);
  load.commands = result_of(commander);
  load.desk = result_of(desk);
  return load;
}

}  // namespace

Json steady_commander(const Meeting& meeting, const Json& options) {
  Node node(kCommander, meeting);
  node.await(kDesk);
  const auto span = in_seconds(options.at("seconds"));
  const SteadyCommands commands(node, span);
  node.rest(span + 2 * in_seconds(kLives));
  return commands.json();
}

Json steady_desk(const Meeting& meeting, const Json& options) {
  Node node(kDesk, meeting);
  std::set<std::uint64_t> executed;
  int twice = 0, late = 0;
  double oldest = 0;
  const auto policy = node.space().add_policy({kDesk, kLamp}, [&](const tuples::RemoteSet& request) {
    const auto age = wall_seconds() - std::stod(request.value.substr(request.value.find(' ')));
    oldest = std::max(oldest, age);
    late += age > kLives;
    twice += !executed.insert(number_of(request.value)).second;
    return tuples::SetDecision::applied();
  });
  node.rest(in_seconds(options.at("seconds")));
  return {{"executed", executed}, {"twice", twice}, {"late", late}, {"oldest_s", rounded(oldest, 3)}};
}

void measure_restarts(const Plan& plan, Report& report) {
  Broker broker(plan, report, "restarts");
  if (!broker) return;
  const int restarts = plan.is_quick ? 2 : 20;
  auto load = load_while_it_restarts(plan, broker, restarts);
  const auto pauses = pauses_after(load.ends, load.stream.at("pauses"));
  const auto worst = percentile(pauses, 1);
  const auto snapshots = load.stream.at("snapshots").get<int>() - 1;
  const auto lost = load.stream.at("stale").get<int>();
  const int twice = load.desk.at("twice"), late = load.desk.at("late");
  const auto unreal = never_executed(load.commands.at("applied"), load.desk.at("executed"));
  report.figure("stream_goes_on_s", {{"median", rounded(median(pauses), 2)}, {"worst", rounded(worst, 2)}});
  report.figure("snapshots_in_between", snapshots);
  report.figure("commands_twice", twice);
  report.figure("commands_late", late);
  report.figure("applied_but_not_executed", unreal);
  report.figure("lost_final_values", lost);
  report.target("stream_goes_on_s", "under 5 after each end of the broker", worst < 5);
  report.target("snapshots_in_between", "0", snapshots == 0);
  report.target("commands", "none twice, late, or applied and not executed", twice + late + unreal == 0);
  report.target("lost_final_values", "0", lost == 0);
  report.detail(
      "stream_goes_on_s",
      {{"method", fmt::format("the broker is killed and started again, every few seconds; a stream of {} sets a second "
                              "of {} tuples, and {} commands a second that live {} s",
                              kStreamRate, kStreamTuples, kCommandRate, kLives)},
       {"rounds", pauses},
       {"commands", load.commands.at("sent")},
       {"executed", load.desk.at("executed").size()},
       {"oldest_executed_s", load.desk.at("oldest_s")},
       {"verdicts", load.commands.at("verdicts")}});
}

}  // namespace rubicon::bench::sites
