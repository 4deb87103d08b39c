#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/deadline.h"
#include "base/scheduler.h"
#include "networks/knx/line/busy_rule.h"
#include "networks/knx/line/outbox.h"
#include "networks/knx/wire/message.h"
#include "transport/udp.h"

namespace rubicon::networks::knx::line {

/// Our part of KNXnet/IP routing (KNX 3/8/5; knx.md, section 7) without sockets: telegrams to a group of routers and
/// back, evenly spaced, with a pause when a router is busy. Datagrams go in by heard(), and out by a call.
class Routing {
 public:
  /// In this machine's turn; a call may destroy the machine.
  struct Calls {
    /// The datagram for the group.
    std::function<Result<void>(ByteView frame)> send;
    std::function<void(const wire::Telegram&)> received;
    std::function<void(ByteView cemi, bool outgoing)> frame;
    std::function<void(const transport::Endpoint& from, const wire::RoutingLostMessage&)> lost;
    /// A whole frame of a search or its answer.
    std::function<void(const transport::Endpoint& from, ByteView frame)> discovery;
    /// As LineCalls::note; may be empty.
    std::function<void(const std::string& subject, std::string_view text)> note{};
    /// note() changed.
    std::function<void()> changed;
    /// Sending fails: the machine is as after down().
    std::function<void(Error)> failed;
  };
  struct Options {
    wire::IndividualAddress address{};  ///< own, unique on the backbone
    /// At most so many frames stand apart by this at least; twice this in the slow phase after a busy.
    Duration gap = std::chrono::milliseconds(20);
    std::uint64_t seed = 0;  ///< of the random part of pauses
    Outbox::Limits limits{0, 1, 10000};
  };
  /// Where a datagram was sent to.
  enum class Group : std::uint8_t {
    kOnly,        ///< the routing group, which is 224.0.23.12
    kConfigured,  ///< the routing group, which is another
    kSystem       ///< 224.0.23.12 where the routing group is another: system broadcasts and searches only
  };

  Routing(Scheduler& scheduler, Options options, Calls calls);
  ~Routing();
  Routing(const Routing&) = delete;
  Routing& operator=(const Routing&) = delete;

  /// The line is there; `own` is what others see us send from, its address empty where that is not known. The port is
  /// nobody else's on this machine.
  void up(transport::Endpoint own);
  /// The line is lost: what waits stays.
  void down();
  void heard(const transport::Endpoint& from, ByteView datagram, Group group = Group::kOnly);
  /// As Line::send.
  void send(wire::Telegram telegram, SteadyTime expires, SentCall done);

  /// What people should know, empty if nothing: that a router holds us up, that our address is somebody's else too.
  std::string note() const;
  std::map<std::string, std::uint64_t> counters() const;

 private:
  using Endpoint = transport::Endpoint;
  struct Counters {
    std::uint64_t sent = 0, received = 0, own = 0, bad = 0, other = 0, busy = 0, lost = 0, doubled = 0, retries = 0;
  };

  void pump();
  bool must_wait();
  void transmit();
  void indication(const Endpoint& from, const wire::RoutingIndication& indication, Group group);
  void busy(const Endpoint& from, const wire::RoutingBusy& busy);
  bool is_own(const Endpoint& from, ByteView cemi);
  void watch_address(const Endpoint& from, ByteView cemi);
  void give_up(Error why);
  void remark(const std::string& subject, const Endpoint& from, std::string_view what);

  Scheduler& scheduler_;
  Options options_;
  Calls calls_;
  Outbox outbox_;
  BusyRule busy_;
  base::Deadline wake_;
  bool up_ = false;
  Endpoint own_;
  SteadyTime next_at_ = SteadyTime::min();
  Bytes cemi_, frame_;      ///< under way
  unsigned attempts_ = 0;   ///< to send it
  std::deque<Bytes> sent_;  ///< the last ones that did not come back
  std::string busy_one_, doubled_by_;
  Counters counters_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::knx::line
