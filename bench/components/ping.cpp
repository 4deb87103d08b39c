#include <array>

#include "components/report.h"
#include "components/roles.h"
#include "components/windows.h"

namespace rubicon::bench {

namespace {

constexpr auto kResend = std::chrono::milliseconds(200);

/// Sets a tuple that the other process subscribes to; the other one answers from the callback by setting its own.
class Pinger {
 public:
  Pinger(Node& node, const Json& options)
      : node_(node),
        pace_(std::chrono::microseconds(options.at("pace_us").get<int>())),
        seconds_(options.at("seconds").get<double>() + 1) {}

  Json run() {
    const auto answers = node_.space().subscribe({kSecond, "bench.pong"}, {},
                                                 [this](const tuples::Event& event) { answered(event.tuple.value); });
    send();
    node_.run(std::chrono::minutes(2));
    auto result = windows_.json();
    result["lost"] = sent_ - heard_;
    return result;
  }

 private:
  void send() {
    const auto text = value_of(++number_);
    times_[number_ % times_.size()] = node_.scheduler().now();
    sent_ += started_;
    (void)node_.space().set("bench.ping", text);
    const bool paced = started_ && pace_ > base::Duration(0);
    due_ = paced ? std::max(due_ + pace_, node_.scheduler().now()) : node_.scheduler().now() + kResend;
    if (paced || !timer_.pending()) timer_ = node_.scheduler().at(due_, [this] { tick(); });
  }
  /// Sends at the given pace; in the tight loop only if an answer was lost.
  void tick() {
    if (started_ && pace_ == base::Duration(0) && node_.scheduler().now() - times_[number_ % times_.size()] < kResend) {
      timer_ = node_.scheduler().after(kResend, [this] { tick(); });
      return;
    }
    send();
  }
  void answered(std::string_view value) {
    const auto now = node_.scheduler().now();
    const auto number = number_of(value);
    if (!started_ && number == 0) return;
    if (started_) {
      windows_.add(times_[number % times_.size()], now);
      ++heard_;
      if (windows_.seconds(now) > seconds_) return node_.finish();
      if (pace_ == base::Duration(0)) send();
      return;
    }
    started_ = true;
    windows_.begin(now);
    due_ = now;
    send();
  }

  Node& node_;
  base::Duration pace_;
  double seconds_;
  Windows windows_;
  bool started_ = false;
  std::uint64_t number_ = 0, sent_ = 0, heard_ = 0;
  std::array<SteadyTime, 4096> times_{};
  SteadyTime due_{};
  base::Timer timer_;
};

}  // namespace

Json ping(const Meeting& meeting, const Json& options) {
  Node node(kFirst, meeting);
  node.await(kSecond);
  return Pinger(node, options).run();
}

Json pong(const Meeting& meeting, const Json&) {
  Node node(kSecond, meeting);
  const auto answers = node.space().subscribe({kFirst, "bench.ping"}, {}, [&](const tuples::Event& event) {
    (void)node.space().set("bench.pong", event.tuple.value);
  });
  node.await(kFirst);
  node.await_end_of(kFirst);
  return Json::object();
}

}  // namespace rubicon::bench
