#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "ecology/report.h"
#include "ecology/roles.h"

namespace rubicon::bench {

namespace {

/// Tuples set in one turn, and the number of queued ones beyond which the writer waits.
constexpr std::size_t kBatch = 1000, kAhead = 5'000;
constexpr auto kPause = std::chrono::microseconds(200);

std::string load_key(std::size_t index) {
  return fmt::format("bench.load.device-{}.sensor.light-{}.value", index / 10, index % 10);
}

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
            {"merged", node_.space().stats().merged},
            {"grown_mb", rounded(std::max(0.0, most_mb_ - before_mb_), 1)},
            {"longest_turn_ms", rounded(longest_ * 1e3, 2)},
            {"sequences", sequences}};
  }

 private:
  void begin() {
    if (begin_ != SteadyTime{}) return;
    before_mb_ = resident_mb();
    begin_ = last_ = node_.scheduler().now();
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
    most_mb_ = std::max(most_mb_, resident_mb());
    (void)node_.space().set("bench.done", "yes");
  }

  Node& node_;
  double seconds_;
  bool flat_out_;
  std::vector<tuples::TupleRef> tuples_;
  std::uint64_t sets_ = 0;
  SteadyTime begin_{}, end_{}, last_{};
  double before_mb_ = 0, most_mb_ = 0, longest_ = 0;
  base::Timer timer_;
};

/// Subscribes to everything and spends `busy_us` on each event; its final copies are compared.
class Sink {
 public:
  Sink(Node& node, const Json& options)
      : node_(node), keys_(options.at("keys")), busy_(std::chrono::microseconds(options.at("busy_us").get<int>())) {}

  Json run() {
    const auto all = node_.space().subscribe({kFirst, "bench.load.**"}, {}, [this](const tuples::Event&) { taken(); });
    const auto end = node_.space().subscribe({kFirst, "bench.done"}, {}, [this](const tuples::Event& event) {
      if (event.tuple.value == "yes") settle();
    });
    node_.run(std::chrono::minutes(3));
    Json sequences = Json::array();
    for (std::size_t i = 0; i < keys_; ++i) {
      const auto tuple = node_.space().get(kFirst, load_key(i));
      sequences.push_back(tuple ? tuple->sequence : 0);
    }
    const auto seconds = seconds_between(begin_, last_);
    return {{"taken", count_ - keys_},
            {"per_second", static_cast<double>(count_ - keys_) / std::max(seconds, 1e-9)},
            {"sequences", sequences}};
  }

 private:
  void taken() {
    ++count_;
    if (count_ == keys_) {
      (void)node_.space().set("bench.ready", "yes");
    } else if (count_ > keys_) {
      last_ = node_.scheduler().now();
      if (begin_ == SteadyTime{}) begin_ = last_;
      if (busy_ > base::Duration(0)) std::this_thread::sleep_for(busy_);
    }
  }
  /// Entries stay in order: one turn after the end marker everything has arrived.
  void settle() {
    timer_ = node_.scheduler().after(std::chrono::milliseconds(300), [this] { node_.finish(); });
  }

  Node& node_;
  std::size_t keys_;
  base::Duration busy_;
  std::size_t count_ = 0;
  SteadyTime begin_{}, last_{};
  base::Timer timer_;
};

struct Run {
  Json writer, sink;
  std::size_t lost = 0;
};

Run run_once(const Plan& plan, bool slow) {
  const std::size_t keys = 10'000;
  const auto meeting = plan.new_meeting();
  auto writing = start_role("writer", meeting, {{"keys", keys}, {"seconds", plan.seconds}, {"flat_out", slow}});
  auto taking = start_role("sink", meeting, {{"keys", keys}, {"busy_us", slow ? 20 : 0}});
  Run run;
  run.sink = result_of(taking);
  run.writer = result_of(writing);
  const auto &left = run.writer.at("sequences"), &right = run.sink.at("sequences");
  for (std::size_t i = 0; i < keys; ++i) run.lost += left[i] != right[i];
  run.writer.erase("sequences");
  run.sink.erase("sequences");
  return run;
}

Json json_of(const Run& run) {
  return {{"writer", run.writer}, {"sink", run.sink}, {"lost_final_states", run.lost}};
}

}  // namespace

Json writer(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  return Writer(node, options).run();
}

Json sink(const Meeting& meeting, const Json& options) {
  Node node(kSecond, meeting);
  return Sink(node, options).run();
}

void measure_throughput(const Plan& plan, Report& report) {
  std::vector<double> rates;
  Json rounds = Json::array();
  std::size_t lost = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto run = run_once(plan, false);
    rates.push_back(run.sink.at("per_second"));
    lost += run.lost;
    rounds.push_back(json_of(run));
  }
  const auto slow = run_once(plan, true);
  lost += slow.lost;
  const auto rate = std::round(median(rates));
  const double grown = slow.writer.at("grown_mb");
  report.figure("tuples_per_second", rate);
  report.figure("lost_final_states", lost);
  report.figure("merged", slow.writer.at("merged"));
  report.figure("owner_mb_slow_subscriber", grown);
  report.target("tuples_per_second", "at least 500000", rate >= 500'000);
  report.target("lost_final_states", "0", lost == 0);
  report.target("owner_mb_slow_subscriber", "bounded: at most 20", grown <= 20);
  report.detail("tuples_per_second",
                {{"method",
                  "callbacks a second of one subscriber, all 10000 tuples of one writer set over and over in turns of "
                  "1000, 64-byte values, the writer waiting while 5000 changes wait; slow: a writer that never waits "
                  "and a subscriber that sleeps at each tuple"},
                 {"rounds", rounds},
                 {"slow_subscriber", json_of(slow)}});
}

}  // namespace rubicon::bench
