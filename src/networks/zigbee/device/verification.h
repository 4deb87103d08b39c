#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "base/deadline.h"
#include "networks/zigbee/device/heard.h"

namespace rubicon::networks::zigbee::device {

/// Finds out which of the values that Zigbee2MQTT published without a report the device really has. It asks for one
/// property at a time, because an answer does not name its question; where asking is impossible, a later message must
/// do. A message proves nothing if it has other news: it may be a report of those, with the echo beside it. Nor does
/// the one by which the device acknowledges a set.
///
/// What remains: a device that ignores a command, leaves our get without an answer and is heard within a second without
/// any news (a report of the same values) counts as confirmed, as Zigbee2MQTT published it.
class Verification {
 public:
  /// A message that was only heard may overtake the answer to a get: a value counts if no other one follows so soon.
  static constexpr Duration kSettling = std::chrono::milliseconds(100);
  /// A message with the same last_seen, give or take this, belongs to the same exchange with the device.
  static constexpr Duration kSameExchange = std::chrono::milliseconds(5);

  /// Whose value is to be proven.
  enum class Cause : std::uint8_t {
    kEcho,       ///< the echo of our command: asked 0.3 s, 1 s and 3 s later
    kForeign,    ///< a change that the device did not report, a command of another client: asked likewise
    kNoEchoYet,  ///< our set has no echo: asked once after 2 s, as some converters publish none
    kNoEchoes,   ///< Zigbee2MQTT is configured to publish none for this device: asked as after an echo
  };
  struct Calls {
    /// Publishes a get for the property; false: not now, try later. `own`: it belongs to a command of ours.
    std::function<bool(std::size_t property, bool own)> ask;
    /// The device has the value that is known of the property; `seen` = last_seen of the message that proves it.
    std::function<void(std::size_t property, std::optional<WallTime> seen)> proven;
  };
  Verification(Scheduler& scheduler, Calls calls);

  /// Starts for a property, in place of what was under way for it. `seen`: newest last_seen of the device so far;
  /// `before`: the one known when the command was published.
  void start(std::size_t property, Cause cause, bool can_ask, std::optional<WallTime> seen,
             std::optional<WallTime> before);
  /// A set was published: the device acknowledges it by a message without news.
  void set_published();
  /// The device reported another value than the one that was known. `ends`: the wanted one.
  void reported(std::size_t property, bool ends);
  /// Call for each message that is no copy, after reported().
  void message(const Heard& heard);
  bool is_running(std::size_t property) const;
  /// The device was asked for the property because a command had its echo, and the answer may still come.
  bool asks(std::size_t property) const;
  void clear();

 private:
  struct Item {
    std::size_t property = 0;
    Cause cause = Cause::kEcho;
    bool can_ask = false;
    unsigned asked = 0;  ///< how often
    SteadyTime start{}, due{};
    bool heard = false;                    ///< the device was, since it was asked
    bool begun = false;                    ///< by an earlier message
    std::optional<WallTime> not_before{};  ///< a passive proof has a later last_seen
    bool answering = false;  ///< it was heard of since the command: the next exchange is news of the device
    SteadyTime candidate_until = SteadyTime::max();
    std::optional<WallTime> candidate_seen{};
  };
  void step();
  void settle_candidates();
  void ask_next();
  bool ask(Item& item);
  SteadyTime quiet_from() const;
  void schedule();
  bool acknowledges_set(const Heard& heard);
  void consider(Item& item, const Heard& heard, bool acknowledges);
  bool may_prove(Item& item, const Heard& heard, bool acknowledges) const;
  Item* find(std::size_t property);

  Scheduler& scheduler_;
  Calls calls_;
  std::vector<Item> items_;
  std::optional<std::size_t> open_;  ///< asked, not answered
  SteadyTime open_until_{};
  unsigned acknowledgements_ = 0;  ///< of sets, which are still to come
  SteadyTime set_at_ = SteadyTime::min();
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::zigbee::device
