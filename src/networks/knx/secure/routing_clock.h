#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <random>

#include "base/scheduler.h"
#include "networks/knx/secure/frames.h"

namespace rubicon::networks::knx::secure {

/// The millisecond timer that all members of a group of secure routing share (KNX 3/8/9, AN159; knx.md, section 10.3).
/// It replaces sequence numbers: a wrapper is accepted while its timer is not older than the latency tolerance. One
/// member, the keeper, sends a TIMER_NOTIFY about each 10 s; the others follow, and send one only if it is missing.
/// Without cryptography and sockets: everything that enters has a good MAC. A pending update is dropped when another
/// member sends one.
class RoutingClock {
 public:
  /// 48 bits.
  static constexpr std::uint64_t kMaxTimer = (1ULL << 48U) - 1;

  enum class Verdict : std::uint8_t {
    kAccepted,
    kEarly,  ///< the timer is not synchronised yet
    kOld     ///< older than the latency tolerance
  };

  struct Settings {
    Duration latency = std::chrono::seconds(2);  ///< tolerance, 1 ms to 8 s
    Serial own{};                                ///< different for each member of the group
    std::uint64_t start = 0;                     ///< ms; not below any value that this host has sent
    std::uint64_t seed = 0;                      ///< for tags and delays
  };
  struct Callbacks {
    /// Sends a TIMER_NOTIFY with the present timer: the timer of `serial` and `tag` is meant to be corrected, or it is
    /// one of our own. Does not destroy this.
    std::function<void(const Serial& serial, std::uint16_t tag)> notify;
    /// Once after each start(): the last action of the function that calls it.
    std::function<void()> synchronised;
  };

  /// The scheduler must outlive it.
  RoutingClock(Scheduler& scheduler, Settings settings, Callbacks callbacks);
  RoutingClock(const RoutingClock&) = delete;
  RoutingClock& operator=(const RoutingClock&) = delete;

  /// The sockets are open: asks the group for its timer. Without an answer within 100 ms + 1.2 L + 2 L (L = latency
  /// tolerance) this is the keeper. The timer continues after stop().
  void start();
  void stop();

  bool synchronised() const { return phase_ == Phase::kFollower || phase_ == Phase::kKeeper; }
  bool keeper() const { return phase_ == Phase::kKeeper; }
  /// ms, at most kMaxTimer.
  std::uint64_t now() const;
  Duration latency() const { return settings_.latency; }

  Verdict received_wrapper(std::uint64_t timer, const Serial& serial, std::uint16_t tag);
  void received_notify(std::uint64_t timer, const Serial& serial, std::uint16_t tag);
  /// A wrapper was sent: others have the timer.
  void sent_wrapper();

 private:
  enum class Phase : std::uint8_t { kStopped, kAsking, kFollower, kKeeper };
  /// Ages of a received timer, by the table of the specification. q = L / 10.
  enum class Age : std::uint8_t { kAhead, kFresh, kLate, kOld };
  struct Update {
    Serial serial{};
    std::uint16_t tag = 0;
  };

  Age age_of(std::uint64_t timer) const;
  void take_over(std::uint64_t timer);
  void schedule_update(const Serial& serial, std::uint16_t tag);
  void schedule_periodic();
  void due();
  std::uint16_t random_tag() { return static_cast<std::uint16_t>(random_()); }
  Duration between(Duration least, Duration most);

  Scheduler& scheduler_;
  Settings settings_;
  Callbacks callbacks_;
  Phase phase_ = Phase::kStopped;
  std::uint64_t base_;  ///< the timer at base_time_
  SteadyTime base_time_;
  std::uint16_t asked_ = 0;  ///< the tag of our first notify
  std::optional<Update> update_;
  std::mt19937_64 random_;
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::knx::secure
