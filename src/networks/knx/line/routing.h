#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/line/line.h"
#include "networks/knx/line/pauses.h"
#include "networks/knx/line/telegram_queue.h"
#include "networks/knx/wire/message.h"
#include "transport/sockets.h"

namespace rubicon::networks::knx::line {

/// The client side of KNXnet/IP routing (KNX 3/8/5; knx.md, section 7) without sockets: sends telegrams to the
/// multicast group of the routers, evenly spaced, with a pause when a router is busy, and reads what others send.
/// Datagrams enter by receive() and leave by `send`.
class Routing {
 public:
  /// Each is the last action of the function that calls it, except `send`; this may be destroyed in it.
  struct Callbacks {
    /// Sends a datagram to the group.
    std::function<Result<void>(ByteView frame)> send;
    std::function<void(const wire::Telegram&)> received;
    std::function<void(ByteView cemi, bool outgoing)> frame;
    std::function<void(const transport::Endpoint& from, const wire::RoutingLostMessage&)> lost;
    /// A whole frame of a search or its answer.
    std::function<void(const transport::Endpoint& from, ByteView frame)> discovery;
    /// As LineCallbacks::note; may be empty.
    std::function<void(const std::string& subject, std::string_view text)> note{};
    /// problem() changed.
    std::function<void()> changed;
    /// Sending fails. Routing is down, as after down().
    std::function<void(Error)> failed;
  };
  struct Options {
    wire::IndividualAddress address{};  ///< own, unique on the backbone
    /// Least time between two frames; doubled in the slow phase after a ROUTING_BUSY.
    Duration gap = std::chrono::milliseconds(20);
    std::uint64_t seed = 0;  ///< for the random part of pauses
    TelegramQueue::Limits limits{0, 1, 10000};
    secure::GroupGuard* guard = nullptr;  ///< of secured groups; must outlive this
  };
  /// The group that a datagram was sent to.
  enum class Group : std::uint8_t {
    kOnly,        ///< the routing group, which is 224.0.23.12
    kConfigured,  ///< the routing group, which is not 224.0.23.12
    kSystem       ///< 224.0.23.12 beside another routing group: system broadcasts and searches only
  };

  /// The scheduler must outlive it.
  Routing(Scheduler& scheduler, Options options, Callbacks callbacks);
  Routing(const Routing&) = delete;
  Routing& operator=(const Routing&) = delete;

  /// The sockets are open. `own` is the source of our datagrams: its address is empty if unknown, its port is used by
  /// no other program of this machine.
  void up(transport::Endpoint own);
  /// The sockets are lost. Telegrams that wait stay.
  void down();
  void receive(const transport::Endpoint& from, ByteView datagram, Group group = Group::kOnly);
  /// As Line::send.
  void send(wire::Telegram telegram, SteadyTime expires, SendCallback done);

  /// For the user: that a router is busy, that another device uses our address; empty if neither.
  std::string problem() const;
  std::map<std::string, std::uint64_t> counters() const;

 private:
  using Endpoint = transport::Endpoint;
  struct Counters {
    std::uint64_t sent = 0, received = 0, own = 0, bad = 0, other = 0, busy = 0, lost = 0, duplicate_address = 0,
                  retries = 0;
  };

  void pump();
  bool must_wait();
  void transmit();
  void receive_indication(const Endpoint& from, const wire::RoutingIndication& indication, Group group);
  void receive_busy(const Endpoint& from, const wire::RoutingBusy& busy);
  void receive_telegram(const Endpoint& from, const wire::DataFrame& frame);
  bool is_own(const Endpoint& from, ByteView cemi);
  void check_source_address(const Endpoint& from, ByteView cemi);
  void give_up(Error why);
  void note(const std::string& subject, const Endpoint& from, std::string_view what);

  Scheduler& scheduler_;
  Options options_;
  Callbacks callbacks_;
  TelegramQueue telegrams_;
  BusyRule busy_rule_;
  base::Deadline wake_;
  bool up_ = false;
  Endpoint own_;
  SteadyTime next_at_ = SteadyTime::min();
  Bytes cemi_, frame_;      ///< of the telegram in flight
  unsigned attempts_ = 0;   ///< to send it
  std::deque<Bytes> sent_;  ///< the last frames that were not received back
  std::string busy_router_, address_rival_;
  Counters counters_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx::line
