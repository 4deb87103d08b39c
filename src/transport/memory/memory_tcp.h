#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "transport/tcp.h"

namespace rubicon::transport {

/// Somebody listens on a port of a MemoryTcp until this is destroyed; connections it accepted live on.
class MemoryListener {
 public:
  virtual ~MemoryListener() = default;
};

/// The connections of a MemoryNet (its member `tcp`): clients by MemoryTransports::open_tcp, servers by listen(). Both
/// ends are TcpStreams. Outlives them.
class MemoryTcp {
 public:
  /// Gets the server's end of a connection and makes its calls; `connected` is not called. To destroy the stream is to
  /// hang up.
  using Accept = TcpAccept;

  explicit MemoryTcp(Scheduler& scheduler);
  ~MemoryTcp();
  MemoryTcp(const MemoryTcp&) = delete;
  MemoryTcp& operator=(const MemoryTcp&) = delete;

  /// Nobody else may listen there: asserted. The endpoint is a host's address and a port of it.
  std::unique_ptr<MemoryListener> listen(const Endpoint& at, Accept accept);
  /// For MemoryTransports on the host with this address: the port is one of it, whatever address was given; others on
  /// the host find it under the loopback address too.
  Result<std::unique_ptr<TcpListener>> listen(const std::string& host, const Endpoint& local, Accept accept,
                                              ListenerFailed failed);

  Duration transit = std::chrono::microseconds(100);  ///< of each piece
  std::size_t segment = 0;  ///< streams arrive in pieces of so many bytes; 0 = what was sent in a turn is one piece
  bool answers = true;      ///< else attempts to connect begun now end by their timeout only

  /// While so, no byte leaves, and nobody hears of an end: queues fill up, also those of streams that were closed.
  void stall(bool stalled);
  /// All connections break; both ends hear of it.
  void cut();
  /// Nobody can connect any more; those who listen hear of it and are no longer there.
  void fail_listeners();
  /// Ends of connections that are open or being made.
  std::size_t open_streams() const;

  /// For MemoryTransports on the host with this address.
  Result<std::unique_ptr<TcpStream>> open(const std::string& host, const TcpOptions& options, TcpCalls calls);

 private:
  friend class MemoryStream;
  friend class MemoryListening;
  friend class MemoryPort;
  struct End;
  using EndPtr = std::shared_ptr<End>;

  struct Listening {
    Accept accept;
    std::weak_ptr<const ListenerFailed> failed;  ///< the listener is there
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
  std::vector<EndPtr> closed_;  ///< while nothing leaves
  std::map<std::uint64_t, Timer> flights_;
  std::uint64_t last_flight_ = 0;
  bool stalled_ = false;
  std::uint16_t last_port_ = 49151;
};

}  // namespace rubicon::transport
