#include "peis/measurements.h"

namespace rubicon::bench::peis {

namespace {

constexpr auto kWriteStep = std::chrono::milliseconds(5);

/// Sets its tuples one after the other at a rate, from the begin of demand on; each value is the number of the set.
class PacedWriter {
 public:
  PacedWriter(Node& node, const Json& options)
      : node_(node),
        keys_(options.at("keys")),
        rate_(options.at("per_second")),
        most_(static_cast<std::uint64_t>(rate_ * options.at("seconds").get<double>())) {}

  Json run() {
    for (std::size_t i = 0; i < keys_; ++i) (void)node_.space().set(key_of(i), value_of(0));
    (void)node_.space().set("bench.done", "0");
    const auto demand = node_.space().watch_demand({kFirst, key_of(0)}, [this](const tuples::Demand& now) {
      if (now.wanted && begin_ == SteadyTime{}) begin();
    });
    const auto ready =
        node_.space().subscribe({kSecond, "bench.ready"}, {}, [this](const tuples::Event&) { node_.finish(); });
    const auto left = node_.space().watch_peers([this](OwnerId, tuples::PeerEvent event) {
      if (event == tuples::PeerEvent::kLeft) node_.finish();
    });
    node_.run(std::chrono::minutes(5));
    return {{"sets", sets_}, {"merged", node_.space().stats().merged}};
  }

 private:
  void begin() {
    begin_ = node_.scheduler().now();
    step();
  }
  void step() {
    const auto due = seconds_between(begin_, node_.scheduler().now()) * rate_;
    while (sets_ < most_ && static_cast<double>(sets_) < due) {
      ++sets_;
      (void)node_.space().set(key_of(sets_ % keys_), value_of(sets_));
    }
    if (sets_ == most_) return void(node_.space().set("bench.done", std::to_string(sets_)));
    timer_ = node_.scheduler().after(kWriteStep, [this] { step(); });
  }

  Node& node_;
  std::size_t keys_;
  double rate_;
  std::uint64_t most_, sets_ = 0;
  SteadyTime begin_{};
  base::Timer timer_;
};

/// Subscribes to all of it until each tuple has its last value.
class Follower {
 public:
  Follower(Node& node, const Json& options)
      : node_(node), keys_(options.at("keys")), most_(options.at("sets")), numbers_(keys_) {}

  Json run() {
    const auto all = node_.space().subscribe({kFirst, "bench.load.**"}, {},
                                             [this](const tuples::Event& event) { take(event.tuple); });
    node_.run(std::chrono::minutes(5));
    const auto complete = wall_seconds();
    (void)node_.space().set("bench.ready", "yes");
    node_.await_end_of(kFirst);
    return {{"complete", complete}, {"taken", taken_}};
  }

 private:
  void take(const tuples::TupleView& tuple) {
    ++taken_;
    const auto number = number_of(tuple.value);
    if (number == 0) return;
    auto& known = numbers_[number % keys_];
    is_right_ += number + keys_ > most_ && known + keys_ <= most_;
    known = number;
    if (is_right_ == keys_) node_.finish();
  }

  Node& node_;
  std::size_t keys_;
  std::uint64_t most_;
  std::vector<std::uint64_t> numbers_;
  std::size_t taken_ = 0, is_right_ = 0;
};

}  // namespace

Json paced_writer(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  return PacedWriter(node, options).run();
}

Json follower(const Meeting& meeting, const Json& options) {
  Node node(kSecond, meeting);
  return Follower(node, options).run();
}

}  // namespace rubicon::bench::peis
