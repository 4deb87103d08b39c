#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure/line_keys.h"
#include "networks/knx/secure/routing_clock.h"

namespace rubicon::networks::knx::secure {

/// Secure routing of one line (KNX 3/8/9, AN159; knx.md, section 10.3): wraps what is sent to the group, opens what
/// comes from it, and keeps the timer of the group. Searches and descriptions stay plain; every other plain frame is
/// dropped. Without sockets.
class RoutingGuard {
 public:
  /// The timer is stored ahead by so much, so that no value is sent twice whenever the process is killed.
  static constexpr Duration kReserve = std::chrono::minutes(10);
  /// The pause after a failure to store it.
  static constexpr Duration kStoreAgain = std::chrono::seconds(10);
  /// What the pause between two starts adds to a stored timer at most: the wall clock may have been wrong.
  static constexpr Duration kMaxAway = std::chrono::hours(10 * 365 * 24);
  /// Wrappers within the latency tolerance that are remembered to find repetitions; with more of them the tolerance
  /// becomes shorter.
  static constexpr std::size_t kMaxRemembered = 4096;

  struct Callbacks {
    /// Sends a datagram to the group. Does not destroy this.
    std::function<void(ByteView datagram)> transmit;
    /// The timer is synchronised: wrap() may be called. The last action of the function that calls it.
    std::function<void()> synchronised;
    /// As LineCallbacks::note; may be empty. Does not destroy this.
    Note note{};
  };

  /// The scheduler must outlive it. Without storage the timer begins at 0 after a restart, until the group corrects it,
  /// as after a stored one that is damaged or of another backbone key. kIo: OpenSSL fails.
  static Result<std::unique_ptr<RoutingGuard>> make(Scheduler& scheduler, RoutingKeys keys, GroupStorage storage,
                                                    const Random& random, Callbacks callbacks);
  RoutingGuard(Scheduler& scheduler, RoutingKeys keys, GroupStorage storage, const RoutingClock::Settings& clock,
               Callbacks callbacks);
  /// Stores the timer; no callbacks.
  ~RoutingGuard();
  RoutingGuard(const RoutingGuard&) = delete;
  RoutingGuard& operator=(const RoutingGuard&) = delete;

  /// The sockets are open; closed.
  void start() { clock_.start(); }
  void stop() { clock_.stop(); }
  bool synchronised() const { return clock_.synchronised(); }

  /// The wrapper of a whole frame, valid until the next call. kRefused: the timer is not synchronised, or at its end.
  Result<ByteView> wrap(ByteView frame);
  /// The plain frame in a datagram of the group; empty if it was dropped, or was a TIMER_NOTIFY. Valid until the next
  /// call. `from` is for the log.
  ByteView receive(const std::string& from, ByteView datagram);
  /// True for searches and descriptions, which are plain everywhere.
  static bool is_discovery(ByteView datagram);

  /// Why the line may be useless although it is synchronised, for the user: no member of the group was heard yet. Empty
  /// as soon as one was.
  std::string problem() const;
  /// For the problem, as Error has it.
  std::string_view finding() const;

  /// By name (`secure-...`).
  std::map<std::string, std::uint64_t> counters() const;

 private:
  struct Seen {
    std::uint64_t timer = 0;
    Serial serial{};
    std::uint16_t tag = 0;
    friend bool operator==(const Seen&, const Seen&) = default;
  };
  struct Counters {
    std::uint64_t sent = 0, received = 0, plain = 0, wrong_mac = 0, old = 0, early = 0, replays = 0, forbidden = 0,
                  bad = 0, own = 0, notifies_sent = 0, notifies_received = 0;
  };

  ByteView receive_wrapper(const std::string& from, const wire::Frame& frame);
  bool accept(const std::string& from, const WrapperHead& head);
  void receive_notify(const std::string& from, const wire::Frame& frame);
  Result<bool> has_good_mac(const TimerNotify& notify);
  void send_notify(const Serial& serial, std::uint16_t tag);
  bool is_repeated(const Seen& one);
  void remember(const Seen& one);
  void drop(std::uint64_t& counter, std::string_view subject, const std::string& from, std::string_view what);
  void reserve();
  bool store(std::uint64_t limit);

  Scheduler& scheduler_;
  RoutingKeys keys_;
  GroupStorage storage_;
  Callbacks callbacks_;
  Serial own_;
  std::uint16_t tag_;  ///< of the last wrapper; counts up, so that no two of one millisecond are alike
  RoutingClock clock_;
  Ccm ccm_;
  std::deque<Seen> seen_;
  std::deque<Seen> notifies_;  ///< the last that were sent: multicast brings them back
  std::uint64_t floor_ = 0;    ///< an older wrapper can no longer be distinguished from a repetition
  std::uint64_t began_ = 0;    ///< the timer when it was synchronised; older frames may have been accepted before
  std::uint64_t limit_ = 0;    ///< the stored timer; no later timer was sent
  bool used_ = false;          ///< a timer was sent
  SteadyTime store_again_{};   ///< after a failure
  Bytes in_, out_;             ///< their memory is used again
  Counters counters_;
};

}  // namespace rubicon::networks::knx::secure
