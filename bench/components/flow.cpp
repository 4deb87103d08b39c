#include <fmt/format.h>

#include <thread>

#include "components/report.h"
#include "components/roles.h"

namespace rubicon::bench {

namespace {

/// Tuples set in one turn, and the number of queued ones beyond which the writer waits.
constexpr std::size_t kBatch = 1000, kAhead = 5'000;
constexpr auto kPause = std::chrono::microseconds(200);

/// Sets all tuples repeatedly: as fast as they are accepted, or as fast as possible if `flat_out`.
class Writer {
 public:
  Writer(Node& node, const Json& options)
      : node_(node), seconds_(options.at("seconds")), flat_out_(options.at("flat_out")) {
    const std::size_t keys = options.at("keys");
    for (std::size_t i = 0; i < keys; ++i) {
      if (auto tuple = node.space().set(load_key(i), value_of(0))) tuples_.push_back(*tuple);
    }
    (void)node.space().set("bench.done", "no");
  }

  Json run() {
    const auto ready = node_.space().subscribe({kSecond, "bench.ready"}, {}, [this](const tuples::Event&) { begin(); });
    node_.await_end_of(kSecond);
    Json sequences = Json::array();
    for (std::size_t i = 0; i < tuples_.size(); ++i)
      sequences.push_back(node_.space().get(kFirst, load_key(i))->sequence);
    return {{"sets", sets_},
            {"sets_per_second", static_cast<double>(sets_) / seconds_between(begin_, end_)},
            {"processor_us_per_set", processor_ / static_cast<double>(sets_) * 1e6},
            {"merged", node_.space().stats().merged - merged_before_},
            {"grown_mb", rounded(std::max(0.0, most_mb_ - before_mb_), 1)},
            {"longest_turn_ms", rounded(longest_ * 1e3, 2)},
            {"sequences", sequences}};
  }

 private:
  void begin() {
    if (begin_ != SteadyTime{}) return;
    before_mb_ = resident_mb();
    merged_before_ = node_.space().stats().merged;  // repeated snapshots
    begin_ = last_ = node_.scheduler().now();
    processor_ = -own_processor_seconds();
    step();
  }
  void step() {
    const auto now = node_.scheduler().now();
    longest_ = std::max(longest_, seconds_between(last_, now));
    if (seconds_between(begin_, now) > seconds_) return end(now);
    last_ = now;
    if (sets_ % (100 * kBatch) == 0) most_mb_ = std::max(most_mb_, resident_mb());
    if (!flat_out_ && node_.space().stats().queued > kAhead) {
      timer_ = node_.scheduler().after(kPause, [this] { step(); });
      return;
    }
    for (std::size_t i = 0; i < kBatch; ++i, ++sets_)
      (void)node_.space().set(tuples_[sets_ % tuples_.size()], value_of(sets_));
    node_.scheduler().post([this] { step(); });
  }
  void end(SteadyTime now) {
    end_ = now;
    processor_ += own_processor_seconds();
    most_mb_ = std::max(most_mb_, resident_mb());
    (void)node_.space().set("bench.done", "yes");
  }

  Node& node_;
  double seconds_;
  bool flat_out_;
  std::vector<tuples::TupleRef> tuples_;
  std::uint64_t sets_ = 0, merged_before_ = 0;
  SteadyTime begin_{}, end_{}, last_{};
  double before_mb_ = 0, most_mb_ = 0, longest_ = 0, processor_ = 0;
  base::Timer timer_;
};

/// Subscribes to everything and spends `busy_us` on each event; its final copies are compared.
class Sink {
 public:
  Sink(Node& node, const Json& options)
      : node_(node),
        keys_(options.at("keys")),
        busy_(std::chrono::microseconds(options.at("busy_us").get<int>())),
        settle_(std::chrono::milliseconds(options.value("settle_ms", 300))) {}

  Json run() {
    const auto all = node_.space().subscribe({kFirst, "bench.load.**"}, {}, [this](const tuples::Event&) { taken(); });
    const auto end = node_.space().subscribe({kFirst, "bench.done"}, {}, [this](const tuples::Event& event) {
      if (event.tuple.value != "yes") return;
      processor_ += own_processor_seconds();
      settle();
    });
    node_.run(std::chrono::minutes(3));
    Json sequences = Json::array();
    for (std::size_t i = 0; i < keys_; ++i) {
      const auto tuple = node_.space().get(kFirst, load_key(i));
      sequences.push_back(tuple ? tuple->sequence : 0);
    }
    const auto seconds = seconds_between(begin_, last_);
    const auto taken = count_ - keys_;
    return {{"taken", taken},
            {"processor_us_per_tuple", processor_ / static_cast<double>(std::max<std::size_t>(taken, 1)) * 1e6},
            {"per_second", static_cast<double>(taken) / std::max(seconds, 1e-9)},
            {"sequences", sequences}};
  }

 private:
  void taken() {
    ++count_;
    if (count_ == keys_) {
      (void)node_.space().set("bench.ready", "yes");
    } else if (count_ > keys_) {
      last_ = node_.scheduler().now();
      if (begin_ == SteadyTime{}) begin_ = last_, processor_ = -own_processor_seconds();
      if (busy_ > base::Duration(0)) std::this_thread::sleep_for(busy_);
    }
  }
  /// Entries stay in order: one turn after the end marker everything has arrived.
  void settle() {
    timer_ = node_.scheduler().after(settle_, [this] { node_.finish(); });
  }

  Node& node_;
  std::size_t keys_;
  base::Duration busy_, settle_;
  std::size_t count_ = 0;
  double processor_ = 0;
  SteadyTime begin_{}, last_{};
  base::Timer timer_;
};

}  // namespace

std::string load_key(std::size_t index) {
  return fmt::format("bench.load.device-{}.sensor.light-{}.value", index / 10, index % 10);
}

Json writer(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  return Writer(node, options).run();
}

Json sink(const Meeting& meeting, const Json& options) {
  Node node(kSecond, meeting);
  return Sink(node, options).run();
}

}  // namespace rubicon::bench
