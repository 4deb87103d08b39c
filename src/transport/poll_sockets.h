#pragma once

#include <memory>

#include "transport/poll_loop.h"
#include "transport/transports.h"

namespace rubicon::transport {

class MosquittoLines;

/// PollLoop::watch(). The loop must outlive what it makes.
WatchDescriptor poll_watch(PollLoop& loop);

/// Sockets, names and MQTT lines of the machine for a PollLoop; files are not supported. All calls run on the loop. A
/// thread, which the first socket of IP and the first name start, waits for these and moves their bytes; local sockets
/// need none.
class PollSockets final : public Transports {
 public:
  /// The loop must outlive it; it must outlive its sockets.
  explicit PollSockets(PollLoop& loop);
  ~PollSockets() override;

  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;
  Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCalls calls) override;
  Result<std::unique_ptr<TcpStream>> open_tcp(const TcpOptions& options, TcpCalls calls) override;
  Result<std::unique_ptr<TcpListener>> listen_tcp(const Endpoint& local, TcpAccept accept,
                                                  ListenerFailed failed = nullptr) override;
  Result<std::unique_ptr<LocalStream>> open_local(const std::string& path, LocalCalls calls) override;
  Result<std::unique_ptr<LocalListener>> listen_local(const std::string& path, LocalAccept accept) override;
  Result<std::unique_ptr<MqttLine>> open_mqtt(const MqttOptions& options, MqttCalls calls) override;
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done) override;

 private:
  struct Threaded;
  Threaded& threaded();

  PollLoop& loop_;
  std::unique_ptr<Threaded> threaded_;
  std::unique_ptr<MosquittoLines> mqtt_;  ///< made when first needed
};

}  // namespace rubicon::transport
