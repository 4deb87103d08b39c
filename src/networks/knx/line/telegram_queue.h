#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "base/expiring_queues.h"
#include "base/scheduler.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx::line {

/// The send queue of a line (knx.md, section 8): by priority, first in first out within one, bounded, and released at
/// the rate of the bus. One telegram at a time is in flight; it survives a lost line once. Owned by a Line.
class TelegramQueue {
 public:
  struct Limits {
    double rate = 20;           ///< telegrams per second; 0 = unlimited
    unsigned burst = 5;         ///< telegrams without delay after a pause, at least 1
    std::size_t queue = 10000;  ///< telegrams that may wait; further ones are refused
  };
  struct Counters {
    std::uint64_t refused = 0, expired = 0, lost = 0;
  };

  /// `ready` is called when take() may return a telegram, never from inside a call to this. The scheduler must outlive
  /// it.
  TelegramQueue(Scheduler& scheduler, Limits limits, std::function<void()> ready);
  TelegramQueue(const TelegramQueue&) = delete;
  TelegramQueue& operator=(const TelegramQueue&) = delete;

  /// As Line::send.
  void push(wire::Telegram telegram, SteadyTime expires, SendCallback done);
  /// The telegram to send now, which is in flight from then on. nullptr: none waits, or it is too early for one
  /// (`ready` follows), or one is in flight.
  const wire::Telegram* take();
  /// The outcome of the telegram in flight is known. Calls its `done`, in which this may be destroyed. For telegrams
  /// pushed in `done`, `ready` is not called: the caller continues with take(), or is down.
  void finish(SendOutcome outcome, std::string_view why);
  /// The line is lost. The telegram in flight will be taken once more, unless it has expired or was repeated before:
  /// then its outcome is kLost.
  void line_lost();

  /// Gives all telegrams that wait to another queue, and the one that a lost line left.
  void hand_over(TelegramQueue& to);

  bool in_flight() const { return in_flight_.has_value() && !repeats_; }
  /// Telegrams in the queue, without the one in flight.
  std::size_t waiting() const { return waiting_; }
  const Counters& counters() const { return counters_; }

 private:
  struct Item {
    wire::Telegram telegram;
    SteadyTime expires;
    SendCallback done;
    bool repeated = false;  ///< it was in flight before, on a line that was lost
  };

  std::optional<std::size_t> next_queue();
  bool take_next();
  void lose_in_flight();
  bool has_tokens(double tokens);
  void refill();
  void report_later(SendCallback done, SendOutcome outcome, std::string_view why);
  void expired(Item item);
  void repeat_expired();

  Scheduler& scheduler_;
  Limits limits_;
  std::function<void()> ready_;
  base::ExpiringQueues<Item> queues_;  ///< by rank of priority; reads follow
  std::size_t waiting_ = 0;
  std::optional<Item> in_flight_;
  bool repeats_ = false;  ///< the line was lost with `in_flight_`, which waits for the next one
  double tokens_;
  SteadyTime refilled_;
  bool finishing_ = false;
  base::Deadline next_token_, repeat_expiry_;
  base::OncePerTurn ready_later_;
  Counters counters_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx::line
