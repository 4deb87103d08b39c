#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "transport/interfaces.h"
#include "transport/transports.h"
#include "tuples/judge.h"
#include "tuples/link.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// How the components of a process take part in a PEIS network.
struct PeisOptions {
  std::string network = "default";               ///< 1 to 63 bytes; components of other networks are not seen
  std::uint16_t listen = kFirstListenPort;       ///< each component takes the first free port from here on; 0 = any
  std::vector<std::string> connect;              ///< HOST or HOST:PORT of components to stay connected with, at most 64
  bool multicast = true;                         ///< announce this host, and search for others
  std::vector<std::string> interfaces = {"lo"};  ///< names, at most 16; `lo` alone = this host only
  base::Duration lease = std::chrono::seconds(2);  ///< components of ours lose this one after such a silence
  bool trust_lan = false;                          ///< accept remote sets from other hosts; without a judge only
  std::shared_ptr<Judge> judge =
      nullptr;  ///< what the member `peis` may do (all others are that member); null: everything

  friend bool operator==(const PeisOptions&, const PeisOptions&) = default;
};

/// `tcp://HOST:PORT`, `HOST:PORT` or `HOST` as an entry of PeisOptions::connect. kInvalid: it is none of them.
Result<std::string> connect_target(std::string_view url);
/// Whether a connection with this entry of PeisOptions::connect would leave the host although `lo` is the only
/// interface. The addresses of a name are not looked up; the connection checks them.
bool leaves_loopback(const std::vector<std::string>& interfaces, std::string_view target);

/// The machine, as components show it to others.
struct PeisMachine {
  std::vector<transport::Interface> interfaces;
  std::string host_name;  ///< without its domain; kernels use loopback only between equal ones
  std::string host_id;    ///< PeerIdentity::host
  std::string process;    ///< process id
  std::string user;

  /// This one.
  static PeisMachine own();
};

/// The interfaces that the options name, in their order. kNotFound: there is none of that name with an IPv4 address,
/// or it is down; kOutOfRange: too many, or a lease that is not 500 ms to 60 s.
Result<std::vector<transport::Interface>> select_interfaces(const PeisOptions& options,
                                                            const std::vector<transport::Interface>& present);

class Presence;

/// The components of a PEIS network, of ours and of the PEIS kernels of 2013. Each component of this process is a node
/// of its own. It outlives its links.
class PeisEcology final : public StandInEcology {
 public:
  /// As select_interfaces(). The scheduler, the transports and the log outlive it.
  static Result<std::unique_ptr<PeisEcology>> open(PeisOptions options, Scheduler& scheduler,
                                                   transport::Transports& transports, base::LogSink& log,
                                                   PeisMachine machine = PeisMachine::own());
  ~PeisEcology() override;

  /// The component is seen by others from the link's attach() on. kOutOfRange: the id is not 1 to 2^31-1; kernels close
  /// connections with other ids, and do not acknowledge to 0.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  /// On any free port, connected with the first port of the options: kernels find it by way of the others.
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;

  /// `call` receives, in a later turn, the component of this process whose id another live component uses and used
  /// before. That component should end.
  void watch_displaced(std::function<void(OwnerId)> call);

  /// The nodes of this process that are present, for diagnosis.
  std::vector<const Presence*> presences() const;

 private:
  struct Impl;
  explicit PeisEcology(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples::peis
