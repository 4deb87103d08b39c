#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "base/scheduler.h"
#include "tuples/peis/own_messages.h"
#include "tuples/peis/troubles.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

enum class HostEvent {
  kUp,      ///< routable, its host record is known, and it had the time to say hello: messages can be sent
  kHello,   ///< sent its hello only after kUp: a component of ours
  kBack,    ///< routable again, same magic, before it counted as lost: what was given up may be sent again
  kForgot,  ///< deleted what it knew of this node: our tuples and subscriptions there are gone
  kLeft,    ///< declared itself dead
  kLost,    ///< not routable for longer than its lease, or restarted: kUp with another magic follows
};

/// Where a host record comes from.
enum class RecordSource {
  kAnnounced,  ///< a datagram, or another way than the one that leads to the host: anyone can send it
  kOwnLink,    ///< the host, on its own connection
  kItself,     ///< the host, on the way by others that leads to it
  kOther,      ///< another host, or the host by way of others while it has a connection
};

/// How a hello came; a later value proves more about its sender.
enum class HelloWay { kAny, kRoute, kOwnLink };

/// The hosts of the network: their starts (magic), when they are up, lost and back. Its owner reports routes to it.
/// Bounded.
class Hosts {
 public:
  static constexpr std::size_t kMaxHosts = 1024;
  /// Besides, for hosts that connect: one neighbour cannot fill the table and so keep all others out.
  static constexpr std::size_t kReserved = 256;
  /// A host that is not ours counts as lost after this time without a route: two routing periods.
  static constexpr Duration kKernelLease = 2 * kRoutingPeriod;
  static constexpr Duration kHelloWait = std::chrono::milliseconds(500);  ///< one resend
  static constexpr Duration kLeaveTime = std::chrono::seconds(3);         ///< a kernel that leaves still talks for 2 s
  static constexpr Duration kForgetTime = std::chrono::minutes(2);

  struct Callbacks {
    std::function<void(HostEvent, const Identity&)> event;
    /// Messages can be sent, hello first: kUp follows when the hello of the host came, or did not for kHelloWait.
    std::function<void(OwnerId)> greet;
    /// The opposite of greet(), before the event.
    std::function<void(OwnerId)> gone;
    /// The host record of a routable host is wanted.
    std::function<void(OwnerId)> query;
    /// The host is back with the same magic after it counted as lost: this node has deleted its subscriptions, but the
    /// host does not know that, and must be made to send them again (peis.md, section 6.4, 27).
    std::function<void(const Identity&)> returned;
  };

  Hosts(Scheduler& scheduler, NodeCounters& counters, Callbacks calls);

  /// False: the record is of a start that has ended (unless that start connects and no other one is up), or there are
  /// too many hosts. An announced record ends no start and replaces no record from the host itself: it only adds an
  /// address to try (claim()).
  bool learn(const HostRecord& record, RecordSource source);
  /// A start has one hello; another one counts only if it came a better way.
  bool may_be_hello(OwnerId id, const Hello& hello, HelloWay way) const;
  /// Only if may_be_hello().
  void hello(OwnerId id, const Hello& hello, HelloWay way);
  /// There is a route to the start `magic` of the host. `is_sure`: an earlier start has ended.
  void routable(OwnerId id, std::uint32_t magic, bool is_sure = true);
  /// There is no route any more. A component of ours stays for the rest of its lease, which began when it was heard.
  void unroutable(OwnerId id, SteadyTime heard);
  void left(OwnerId id);
  /// A message of the host came. Whether it is up; one that still had time to say hello becomes up.
  bool message(OwnerId id);

  /// Whether the start with this magic is known to have ended.
  bool is_over(OwnerId id, std::uint32_t magic) const;
  bool is_up(OwnerId id) const;
  bool is_routable(OwnerId id) const;
  bool is_ours(OwnerId id) const;
  /// The lease of a component of ours, also before it is up.
  std::optional<Duration> lease(OwnerId id) const;
  /// Null: not up.
  const Identity* find(OwnerId id) const;
  /// Null: not known.
  const HostRecord* record(OwnerId id) const;
  /// What was announced of the host and differs from its record; null: nothing.
  const HostRecord* claim(OwnerId id) const;
  std::vector<Identity> up() const;

 private:
  enum class State { kAbsent, kGreeting, kUp, kMissing };
  struct Former {
    std::uint32_t magic = 0;
    SteadyTime until{};
  };
  struct Host {
    HostRecord record;
    Identity identity;
    bool informed = false;  ///< `record` is that of this start
    bool is_sure = false;   ///< ... and came from the host itself
    std::optional<HostRecord> claim;
    HelloWay hello_way{};
    bool routable = false;
    bool counted_lost = false;
    State state = State::kAbsent;
    SteadyTime due = SteadyTime::max();  ///< of kGreeting: up; of kMissing: lost
    SteadyTime query_due = SteadyTime::max();
    int queries = 0;
    SteadyTime heard{}, left_until{};
    std::array<Former, 4> former{};
    std::size_t next_former = 0;
  };

  bool takes_back(const HostRecord& record, RecordSource source);
  Host* obtain(OwnerId id, bool is_neighbour = false);
  bool hear(Host& host, const HostRecord& record);
  void restart(Host& host, std::uint32_t magic, bool is_sure);
  void take(Host& host, const HostRecord& record);
  void evaluate(Host& host);
  void become_up(Host& host);
  bool become_absent(Host& host);
  void lose(Host& host);
  void due(SteadyTime when) { next_.advance_to(when); }
  void sweep();
  void sweep(Host& host, SteadyTime now);
  void ask(Host& host, SteadyTime now);
  bool purge(const Host& host, SteadyTime now) const;

  Scheduler& scheduler_;
  NodeCounters& counters_;
  Callbacks callbacks_;
  std::map<OwnerId, Host> hosts_;
  base::Deadline next_;
};

}  // namespace rubicon::tuples::peis
