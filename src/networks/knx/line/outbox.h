#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "base/deadline.h"
#include "base/scheduler.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx::line {

/// Telegrams that wait for the bus: by priority, in order within one, bounded, at the rate the bus takes them (knx.md,
/// section 8). At most one is under way; it survives a lost line once. Belongs to a Line.
class Outbox {
 public:
  struct Limits {
    double rate = 20;           ///< telegrams a second; 0 = as many as the line takes
    unsigned burst = 5;         ///< telegrams at once after a pause, at least 1
    std::size_t queue = 10000;  ///< telegrams that wait; more are refused
  };
  struct Counters {
    std::uint64_t refused = 0, expired = 0, lost = 0;
  };

  /// `ready` is called, never from inside a call to this, when take() may give something.
  Outbox(Scheduler& scheduler, Limits limits, std::function<void()> ready);
  ~Outbox();
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  /// As Line::send.
  void push(wire::Telegram telegram, SteadyTime expires, SentCall done);
  /// The telegram to send now, which is under way then; nullptr: none, or not yet (ready() follows), or one is under
  /// way.
  const wire::Telegram* take();
  /// What became of the telegram under way; calls its `done`, in which this may be destroyed. The caller goes on with
  /// take(), or is down: ready() is not called for what is pushed in `done`.
  void finish(Sent outcome, std::string_view why);
  /// The line is lost. The telegram under way will be taken once more if its time allows and it was not already;
  /// else it is reported.
  void line_lost();

  bool under_way() const { return under_way_.has_value() && !waits_again_; }
  std::size_t waiting() const { return waiting_; }
  const Counters& counters() const { return counters_; }

 private:
  struct Item {
    wire::Telegram telegram;
    SteadyTime expires;
    SentCall done;
    bool again = false;  ///< it was under way before, on a line that was lost
  };
  using Queue = std::deque<Item>;

  Queue* next_queue();
  bool take_next();
  void lose_under_way();
  bool may_go(double tokens);
  void refill();
  void report_later(SentCall done, Sent outcome, std::string_view why);
  void expire();
  void expire_in(Queue& queue, SteadyTime now, SteadyTime& next);
  void call_ready_later();

  Scheduler& scheduler_;
  Limits limits_;
  std::function<void()> ready_;
  std::array<Queue, 4> queues_, reads_;  ///< by rank of priority
  std::size_t waiting_ = 0;
  std::optional<Item> under_way_;
  bool waits_again_ = false;  ///< the one under way waits for the next line
  double tokens_;
  SteadyTime refilled_;
  bool ready_asked_ = false;
  bool finishing_ = false;
  base::Deadline token_, expiry_;
  Counters counters_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::knx::line
