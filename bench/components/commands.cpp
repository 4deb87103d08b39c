#include <fmt/format.h>

#include "components/report.h"
#include "components/roles.h"

namespace rubicon::bench {

namespace {

/// Maximum number of pending sets.
constexpr std::uint64_t kWindow = 4000;

class Commander {
 public:
  Commander(Node& node, std::uint64_t count) : node_(node), count_(count) {}

  Json run() {
    begin_ = node_.scheduler().now();
    const auto used = own_processor_seconds();
    fill();
    node_.run(std::chrono::minutes(2));
    const auto seconds = seconds_between(begin_, node_.scheduler().now());
    return {{"per_second", static_cast<double>(answered_) / seconds},
            {"processor_us_per_set", (own_processor_seconds() - used) / static_cast<double>(answered_) * 1e6},
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

}  // namespace rubicon::bench
