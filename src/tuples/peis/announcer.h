#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/limited_log.h"
#include "base/paced_call.h"
#include "transport/interfaces.h"
#include "transport/transports.h"
#include "tuples/peis/counters.h"
#include "tuples/peis/troubles.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// Discovery by UDP multicast (peis.md, section 3.2), on each interface. One component of a host announces, the one
/// with the lowest id. A kernel begins after 3 silent seconds; this one begins at once, and ends when it hears a lower
/// id of its host.
class Announcer {
 public:
  struct Calls {
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
  Announcer(Scheduler& scheduler, transport::Transports& transports, Where where, Counters& counters,
            base::LimitedLog& log, Calls calls);

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
  Counters& counters_;
  base::LimitedLog& log_;
  Calls calls_;
  std::vector<Socket> sockets_;
  SteadyTime silent_until_{};
  Timer timer_;
  base::PacedCall soon_;
};

}  // namespace rubicon::tuples::peis
