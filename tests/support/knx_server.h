#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "apps/simulators/knx/server.h"
#include "base/bytes.h"
#include "base/scheduler.h"
#include "support/memory/memory_transports.h"

namespace rubicon::support {

/// A transport::MemoryTransports of a host of its own: a base, so that it is there before the server.
struct KnxServerHost {
  transport::MemoryTransports host;
};

/// The simulator's KNXnet/IP server on a host of a MemoryNet (10.0.0.9 by default), with a record of what its clients
/// sent and devices that answer reads. Net and scheduler must outlive it.
class KnxServer : private KnxServerHost, public knx_simulator::Server {
 public:
  struct Options {
    transport::Endpoint at{"10.0.0.9", 3671};
    std::size_t tunnels = 4;
    std::uint16_t first_address = 0x11c8;  ///< of the tunnels: 1.1.200
    bool wanted_addresses = false;
    std::uint16_t data_port = 0;
    std::optional<knx_simulator::SecureOptions> secure{};
  };
  using Heard = knx_simulator::ClientFrame;

  KnxServer(Scheduler& scheduler, transport::MemoryNet& net) : KnxServer(scheduler, net, Options{}) {}
  KnxServer(Scheduler& scheduler, transport::MemoryNet& net, const Options& options);

  /// Comes back after a stop().
  void start();

  /// What clients sent, in order, also before a stop().
  const std::vector<Heard>& heard() const { return heard_; }
  /// Called for each telegram of a client, after it was recorded.
  std::function<void(const Heard&)> on_heard;

  /// A device on the bus writes or answers: `apci` 0x80 or 0x40. Bytes of one below 64 and `small`: the 6 bit form.
  void inject(std::uint16_t source, std::uint16_t group, std::uint8_t apci, const Bytes& value, bool small = false);
  void inject_read(std::uint16_t source, std::uint16_t group);
  /// Any cEMI frame, to all tunnels.
  void inject_cemi(const Bytes& cemi) { send_to_clients(cemi); }

  /// Reads of these groups are answered from 1.1.250 (value as for inject()).
  struct Answer {
    Bytes value;
    bool small = false;
  };
  std::map<std::uint16_t, Answer> answers;
  Duration answer_time = std::chrono::milliseconds(20);

 private:
  void record(const Heard& frame);
  void answer(std::uint16_t group);

  Scheduler& scheduler_;
  std::vector<Heard> heard_;
  std::vector<Timer> answering_;
};

}  // namespace rubicon::support
