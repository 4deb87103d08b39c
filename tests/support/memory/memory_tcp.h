#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// Listens on a port of a MemoryTcp until destroyed; accepted connections stay open.
class MemoryListener {
 public:
  virtual ~MemoryListener() = default;
};

/// The connections of a MemoryNet (its member `tcp`): clients by MemoryTransports::open_tcp, servers by listen(). Both
/// ends are TcpStreams. Outlives them.
class MemoryTcp {
 public:
  /// Receives the server's end of a connection; `connected` is not called. Destroying the stream closes it.
  using Accept = TcpAccept;

  explicit MemoryTcp(Scheduler& scheduler);
  ~MemoryTcp();
  MemoryTcp(const MemoryTcp&) = delete;
  MemoryTcp& operator=(const MemoryTcp&) = delete;

  /// The endpoint is the address of a host and a free port (asserted).
  std::unique_ptr<MemoryListener> listen(const Endpoint& at, Accept accept);
  /// For MemoryTransports on the host with this address: listens on a port of the host, whatever address `local` has;
  /// programs on the host also reach it under the loopback address.
  Result<std::unique_ptr<TcpListener>> listen(const std::string& host, const Endpoint& local, Accept accept,
                                              ListenerFailed failed);

  Duration transit = std::chrono::microseconds(100);  ///< of each piece
  std::size_t segment = 0;  ///< size of the pieces in which bytes arrive; 0 = one piece per turn
  bool answers = true;      ///< if false, new attempts to connect run into their timeout

  /// While stalled, no byte and no end of a connection is transmitted: queues fill up, also of closed streams.
  void stall(bool stalled);
  /// Breaks all connections; both ends are notified.
  void cut();
  /// Makes all listeners fail: their `failed` is called, and they accept no connections.
  void fail_listeners();
  /// Number of ends of connections that are open or being established.
  std::size_t open_streams() const;

  /// For MemoryTransports on the host with this address.
  Result<std::unique_ptr<TcpStream>> open(const std::string& host, const TcpOptions& options, TcpCallbacks calls);

 private:
  friend class MemoryStream;
  friend class MemoryListening;
  friend class MemoryPort;
  struct End;
  using EndPtr = std::shared_ptr<End>;

  struct Listening {
    Accept accept;
    std::weak_ptr<const ListenerFailed> failed;  ///< expired: the listener was destroyed
  };

  std::map<Endpoint, Listening>::const_iterator listener_for(const End& client) const;
  void reach(const EndPtr& client);
  void accept(const EndPtr& client, const Accept& accept);
  void flush(const EndPtr& end);
  void hold(const EndPtr& end, bool held);
  void lose(const EndPtr& end, Error why);
  void close(const EndPtr& end);
  void hang_up(const EndPtr& end);
  void after_transit(std::function<void()> call);
  EndPtr make_end(Endpoint local, Endpoint remote);

  Scheduler& scheduler_;
  std::map<Endpoint, Listening> listeners_;
  std::vector<EndPtr> ends_;
  std::vector<EndPtr> closed_;  ///< closed while stalled
  std::map<std::uint64_t, Timer> flights_;
  std::uint64_t last_flight_ = 0;
  bool stalled_ = false;
  std::uint16_t last_port_ = 49151;
};

}  // namespace rubicon::transport
