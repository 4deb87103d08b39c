#include <fmt/format.h>

#include "ecology/report.h"
#include "ecology/roles.h"

namespace rubicon::bench {

namespace {

/// Maximum number of pending sets.
constexpr std::uint64_t kWindow = 4000;

class Commander {
 public:
  Commander(Node& node, std::uint64_t count) : node_(node), count_(count) {}

  Json run() {
    begin_ = node_.scheduler().now();
    fill();
    node_.run(std::chrono::minutes(2));
    const auto seconds = seconds_between(begin_, node_.scheduler().now());
    return {{"per_second", static_cast<double>(answered_) / seconds},
            {"applied", applied_},
            {"not_applied", answered_ - applied_}};
  }

 private:
  void fill() {
    while (sent_ < count_ && sent_ - answered_ < kWindow) {
      ++sent_;
      node_.space().set_remote(kSecond, fmt::format("bench.desk.device-{}.actuator.switch-1.command", sent_ % 100),
                               value_of(sent_), std::chrono::seconds(10),
                               [this](const tuples::Reply& reply) { take(reply); });
    }
  }
  void take(const tuples::Reply& reply) {
    ++answered_;
    applied_ += reply.verdict == tuples::Verdict::kApplied;
    answered_ == count_ ? node_.finish() : fill();
  }

  Node& node_;
  std::uint64_t count_, sent_ = 0, answered_ = 0, applied_ = 0;
  SteadyTime begin_{};
};

}  // namespace

Json commander(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  node.await(kSecond);
  return Commander(node, options.at("count")).run();
}

/// Each set carries its number: counts lost, repeated and reordered ones.
Json desk(const Meeting& meeting, const Json& options) {
  Node node(kSecond, meeting);
  std::vector<bool> seen(options.at("count").get<std::size_t>() + 1);
  std::uint64_t last = 0, twice = 0, out_of_order = 0, distinct = 0;
  const auto policy = node.space().add_policy({std::nullopt, "bench.desk.**"}, [&](const tuples::RemoteSet& request) {
    const auto number = number_of(request.value);
    out_of_order += number <= last;
    last = std::max(last, number);
    if (number >= seen.size() || seen[number]) return ++twice, tuples::SetDecision::applied();
    seen[number] = true;
    ++distinct;
    return tuples::SetDecision::applied();
  });
  node.await(kFirst);
  node.await_end_of(kFirst);
  return {{"lost", seen.size() - 1 - distinct}, {"twice", twice}, {"out_of_order", out_of_order}};
}

void measure_remote_sets(const Plan& plan, Report& report) {
  const std::uint64_t count = plan.is_quick ? 40'000 : 400'000;
  std::vector<double> rates;
  std::uint64_t lost = 0, twice = 0, out_of_order = 0, refused = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto meeting = plan.new_meeting();
    auto owning = start_role("desk", meeting, {{"count", count}});
    auto commanding = start_role("commander", meeting, {{"count", count}});
    const auto sent = result_of(commanding), judged = result_of(owning);
    rates.push_back(sent.at("per_second"));
    refused += sent.at("not_applied").get<std::uint64_t>();
    lost += judged.at("lost").get<std::uint64_t>();
    twice += judged.at("twice").get<std::uint64_t>();
    out_of_order += judged.at("out_of_order").get<std::uint64_t>();
  }
  const auto rate = std::round(median(rates));
  report.figure("remote_sets_per_second", rate);
  report.figure("lost", lost);
  report.figure("twice", twice);
  report.figure("out_of_order", out_of_order);
  report.target("remote_sets_per_second", "at least 80000", rate >= 80'000);
  report.target("lost", "0, and none refused", lost == 0 && refused == 0);
  report.target("twice", "0", twice == 0);
  report.target("out_of_order", "0", out_of_order == 0);
  report.detail("remote_sets_per_second",
                {{"method", fmt::format("{} sets with replies, at most {} under way, 64-byte values, 100 tuples; "
                                        "first set to last reply",
                                        count, kWindow)},
                 {"rounds", rates},
                 {"not_applied", refused}});
}

}  // namespace rubicon::bench
