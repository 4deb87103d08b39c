#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "support/memory/memory_tcp.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// Whether in-memory sockets accept this as an address; host names are none.
bool is_numeric_address(const std::string& host);

class MqttBroker;

/// A datagram on a MemoryNet.
struct MemoryDatagram {
  Endpoint from, to;
  Bytes bytes;
};

/// An in-memory network for tests: several hosts, each with its MemoryTransports, in the time of a scheduler, which
/// must outlive it. Must outlive its sockets.
class MemoryNet {
 public:
  explicit MemoryNet(Scheduler& scheduler);
  ~MemoryNet();
  MemoryNet(const MemoryNet&) = delete;
  MemoryNet& operator=(const MemoryNet&) = delete;

  /// Sets the addresses of a host name; empty = it cannot be found. At first only `localhost` is known.
  void name(const std::string& host, std::vector<std::string> addresses);

  Duration transit = std::chrono::microseconds(100);  ///< of each datagram
  Duration lookup_time = std::chrono::milliseconds(1);
  bool names_answer = true;                          ///< if false, new lookups never complete
  bool reports_unreachable = true;                   ///< report datagrams to ports without a socket to their senders
  std::function<bool(const MemoryDatagram&)> loses;  ///< true = drop the datagram; may be empty
  std::set<std::string>
      gone_interfaces{};      ///< by address: groups cannot be joined on them again, nothing is sent from them
  std::string no_way;         ///< why the system can send nothing (no route, no address); empty = it can
  std::uint64_t refuses = 0;  ///< number of next sends that find the line busy

  /// All datagrams that were sent, including dropped ones.
  const std::vector<MemoryDatagram>& sent() const { return sent_; }
  std::size_t open_sockets() const;
  Scheduler& scheduler() { return scheduler_; }

  MemoryTcp tcp;                            ///< its connections, with settings of their own
  std::map<Endpoint, MqttBroker*> brokers;  ///< those that run; each adds and removes itself

  /// For MemoryTransports on the host with this address.
  Result<std::unique_ptr<UdpSocket>> open_udp(const std::string& host, const UdpOptions& options, UdpCallbacks calls);
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done);

 private:
  friend class MemoryUdp;
  struct Port {
    Endpoint local;  ///< with the address of the host, whatever address was bound
    UdpOptions options;
    UdpCallbacks calls;
    bool open = true;
  };
  using PortPtr = std::shared_ptr<Port>;

  bool taken(const Endpoint& local, bool reuse) const;
  void send(MemoryDatagram datagram, const Port& from);
  void fly(MemoryDatagram datagram, std::function<void(const MemoryDatagram&)> land);
  void arrive(const MemoryDatagram& datagram);
  void arrive_in_group(const MemoryDatagram& datagram, bool loopback);
  static void hear(const PortPtr& port, const MemoryDatagram& datagram);

  Scheduler& scheduler_;
  std::map<std::string, std::vector<std::string>> names_;
  std::vector<PortPtr> ports_;
  std::vector<MemoryDatagram> sent_;
  std::map<std::uint64_t, Timer> flights_;
  std::uint64_t last_flight_ = 0;
};

}  // namespace rubicon::transport
