#include <chrono>

#include "components/roles.h"
#include "frame/connection_figures.h"

namespace rubicon::bench {

namespace {

constexpr auto kWriteStep = std::chrono::milliseconds(5);
constexpr double kNotedPause = 0.1;  ///< seconds without a value

/// Sets its tuples one after the other at a rate, from the begin of demand on; each value is the number of the set.
class PacedWriter {
 public:
  PacedWriter(Node& node, const Json& options)
      : node_(node),
        keys_(options.at("keys")),
        rate_(options.at("per_second")),
        most_(static_cast<std::uint64_t>(rate_ * options.at("seconds").get<double>())) {}

  Json run() {
    for (std::size_t i = 0; i < keys_; ++i) (void)node_.space().set(load_key(i), value_of(0));
    (void)node_.space().set("bench.done", "0");
    const auto demand = node_.space().watch_demand({kFirst, load_key(0)}, [this](const tuples::Demand& now) {
      if (now.wanted && begin_ == SteadyTime{}) begin();
    });
    const auto ready =
        node_.space().subscribe({kSecond, "bench.ready"}, {}, [this](const tuples::Event&) { node_.finish(); });
    const auto left = node_.space().watch_peers([this](OwnerId, tuples::PeerEvent event) {
      if (event == tuples::PeerEvent::kLeft) node_.finish();
    });
    node_.run(std::chrono::minutes(5));
    const auto passed = passed_on_connections();
    return {{"sets", sets_},
            {"merged", node_.space().stats().merged},
            {"received_bytes", passed.received - before_.received},
            {"sent_bytes", passed.sent - before_.sent}};
  }

 private:
  void begin() {
    begin_ = node_.scheduler().now();
    before_ = passed_on_connections();
    step();
  }
  void step() {
    const auto due = seconds_between(begin_, node_.scheduler().now()) * rate_;
    while (sets_ < most_ && static_cast<double>(sets_) < due) {
      ++sets_;
      (void)node_.space().set(load_key(sets_ % keys_), value_of(sets_));
    }
    if (sets_ == most_) return void(node_.space().set("bench.done", std::to_string(sets_)));
    timer_ = node_.scheduler().after(kWriteStep, [this] { step(); });
  }

  Node& node_;
  std::size_t keys_;
  double rate_;
  std::uint64_t most_, sets_ = 0;
  SteadyTime begin_{};
  Passed before_;
  base::Timer timer_;
};

/// Subscribes to all of it until each tuple has its last value, or its patience ends.
class Follower {
 public:
  Follower(Node& node, const Json& options)
      : node_(node),
        keys_(options.at("keys")),
        most_(options.at("sets")),
        patience_(std::chrono::seconds(options.value("patience_s", 300))),
        numbers_(keys_) {}

  Json run() {
    const auto all = node_.space().subscribe(
        {kFirst, "bench.load.**"}, {}, [this](const tuples::Event& event) { take(event.tuple); },
        [this](OwnerId) { ++snapshots_; });
    node_.rest(patience_);
    const auto passed = passed_on_connections();
    const auto complete = wall_seconds();
    (void)node_.space().set("bench.ready", "yes");
    node_.await_end_of(kFirst);
    return {{"complete", complete},
            {"taken", taken_},
            {"stale", keys_ - is_right_},
            {"snapshots", snapshots_},
            {"pauses", pauses_},
            {"received_bytes", passed.received - before_.received},
            {"sent_bytes", passed.sent - before_.sent}};
  }

 private:
  void take(const tuples::TupleView& tuple) {
    ++taken_;
    const auto number = number_of(tuple.value);
    if (number == 0) return;
    note_pause();
    auto& known = numbers_[number % keys_];
    is_right_ += number + keys_ > most_ && known + keys_ <= most_;
    known = number;
    if (is_right_ == keys_) node_.finish();
  }
  void note_pause() {
    const auto now = wall_seconds();
    if (last_ == 0) before_ = passed_on_connections();
    if (last_ > 0 && now - last_ > kNotedPause) pauses_.push_back({last_, now});
    last_ = now;
  }

  Node& node_;
  std::size_t keys_;
  std::uint64_t most_;
  base::Duration patience_;
  std::vector<std::uint64_t> numbers_;
  std::size_t taken_ = 0, is_right_ = 0, snapshots_ = 0;
  double last_ = 0;
  Json pauses_ = Json::array();  ///< begin and end
  Passed before_;
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

}  // namespace rubicon::bench
