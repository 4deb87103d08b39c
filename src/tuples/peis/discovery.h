#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "base/text.h"
#include "transport/interfaces.h"
#include "transport/transports.h"
#include "tuples/peis/troubles.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// Discovery by UDP multicast (peis.md, section 3.2), on each interface. One component of a host announces, the one
/// with the lowest id. A kernel begins after 3 silent seconds; this one begins at once, and ends when it hears a lower
/// id of its host.
class Announcer {
 public:
  struct Callbacks {
    /// What to announce now.
    std::function<HostRecord()> record;
    std::function<void(const HostRecord&)> heard;
    /// An announcement that does not count.
    std::function<void(TroubleKind, OwnerId, std::string_view name, std::string_view detail)> trouble;
  };
  struct Where {
    std::string network;
    std::vector<transport::Interface> interfaces;
  };
  static constexpr Duration kOpenAgain = std::chrono::seconds(5);  ///< after a socket could not be opened, or failed

  /// All that is referred to must outlive it.
  Announcer(Scheduler& scheduler, transport::Transports& transports, Where where, NodeCounters& counters,
            base::LimitedLog& log, Callbacks calls);

  /// Announces soon if this component is the one that does so for its host.
  void announce() { soon_.request(); }
  /// Whether this component announces for its host.
  bool is_active() const { return scheduler_.now() >= silent_until_; }

 private:
  struct Socket {
    transport::Interface interface;
    std::unique_ptr<transport::UdpSocket> socket;
    Timer again;
  };

  void open(Socket& socket);
  void open_later(Socket& socket);
  void received(ByteView datagram);
  void tick();
  void send();

  Scheduler& scheduler_;
  transport::Transports& transports_;
  std::string network_;
  NodeCounters& counters_;
  base::LimitedLog& log_;
  Callbacks callbacks_;
  std::vector<Socket> sockets_;
  SteadyTime silent_until_{};
  Timer timer_;
  base::PacedCall soon_;
};

/// What a connection is established for.
struct Target {
  OwnerId host{};       ///< a known host
  int configured = -1;  ///< else the index of a configured one
  friend bool operator==(const Target&, const Target&) = default;
};

/// Decides which hosts to connect to, and when (peis.md, sections 3.3 and 6.4): hosts of other clusters that were
/// announced, hosts that messages go to by way of others, broken connections, configured hosts. Bounded: a try for each
/// host that it was asked for, a few at a time.
class Dialer {
 public:
  static constexpr std::size_t kMaxTries = 8;  ///< at a time
  static constexpr Duration kMaxPauseTime = std::chrono::seconds(10);
  static constexpr Duration kDirectPause = std::chrono::seconds(10);  ///< between tries for a direct connection
  /// A connection that breaks within this time counts as a failure from the second one in a row on: a kernel resets the
  /// first one of a new start.
  static constexpr Duration kYoung = std::chrono::seconds(5);
  static constexpr std::size_t kMaxHostTries = 1024;
  /// Besides, for hosts whose connection broke: announcements, which anyone can send, cannot keep them out.
  static constexpr std::size_t kReserved = 256, kReservedTries = 8;

  struct Callbacks {
    /// Whether there is a connection with the host.
    std::function<bool(OwnerId)> is_linked;
    std::function<bool(OwnerId)> is_routable;
    /// Null: not known.
    std::function<const HostRecord*(OwnerId)> record;
    /// What others say of the host's addresses; null: nothing.
    std::function<const HostRecord*(OwnerId)> claim;
    /// False: the address cannot be tried.
    std::function<bool(const Target&, const transport::Endpoint&, std::uint32_t flags)> dial;
    /// The name of a configured host has no address that may be tried.
    std::function<void(const Target&, const Error&)> unresolved;
    /// There are too many hosts to connect to: this one is not tried.
    std::function<void(OwnerId)> refused;
  };
  struct Own {
    OwnerId id{};
    std::string host_name;
    std::vector<base::HostPort> configured;
    std::uint32_t seed = 0;
    bool loopback_only = false;  ///< tries no address of another host
  };

  Dialer(Scheduler& scheduler, transport::Transports& transports, Own own, Callbacks calls);

  /// A host that was announced cannot be reached. `first`: this component is the one of its host, or alone, so that it
  /// connects at once.
  void meet(OwnerId host, bool is_lower_cluster, bool first);
  /// Messages go to this host by way of others.
  void prefer_direct(OwnerId host);
  /// The connection with a host broke. `first`: this component had established it, so it does again at once.
  void again(OwnerId host, bool first);
  /// The try succeeded: it is connected with this host.
  void connected(const Target& target, OwnerId host);
  /// The connection of the try ended, or it came to nothing.
  void ended(const Target& target, bool was_connected);
  /// The host left: no more tries.
  void forget(OwnerId host);
  /// Where a host with this record may be reached from here; none for null.
  std::vector<transport::Endpoint> addresses_of(const HostRecord* record) const;

 private:
  struct Try {
    SteadyTime due = SteadyTime::max();
    int failures = 0;
    std::size_t address = 0;
    bool dialing = false;
    bool direct = false;      ///< wanted although it can be reached
    bool broke = false;       ///< there was a connection
    std::uint32_t magic = 0;  ///< of the start whose addresses it tried
    int breaks = 0;           ///< connections in a row that broke while young
    SteadyTime last_direct{}, connected{};
  };
  struct Configured {
    base::HostPort where;
    Try next;
    OwnerId host{};  ///< the host at this address; 0 = not known
    bool linked = false;
    std::unique_ptr<transport::Lookup> lookup;
  };

  void schedule(Try& next, Duration delay);
  void sweep();
  void try_host(OwnerId host, Try& next);
  void try_configured(std::size_t index);
  Try* obtain(OwnerId host, bool broke);
  void dial_configured(const Target& target, std::vector<std::string> addresses);
  Try* release(const Target& target);
  void renew(OwnerId host, Try& next);
  static bool is_young(const Try& next, SteadyTime now);
  Duration pause_after_break(Try& next);
  void failed(Try& next);
  std::optional<transport::Endpoint> address_of(OwnerId host, std::size_t which) const;
  Duration jitter(Duration from, Duration to);

  Scheduler& scheduler_;
  transport::Transports& transports_;
  Own own_;
  Callbacks callbacks_;
  std::mt19937 random_;
  std::map<OwnerId, Try> tries_;
  std::vector<Configured> configured_;
  std::size_t dialing_ = 0;  ///< known hosts
  base::Deadline next_;
};

}  // namespace rubicon::tuples::peis
