#pragma once

#include <memory>

#include "transport/transports.h"

namespace rubicon::transport {

class Loop;
class MosquittoLines;
class NameLookup;

/// Files and sockets of the machine. Opens regular files only: a FIFO or a device could block the loop.
class LocalTransports final : public Transports {
 public:
  /// For files only; sockets and names give kUnsupported.
  LocalTransports();
  /// The loop must outlive it and all its sockets.
  explicit LocalTransports(Loop& loop);
  ~LocalTransports() override;

  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;
  Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCallbacks calls) override;
  Result<std::unique_ptr<TcpStream>> open_tcp(const TcpOptions& options, TcpCallbacks calls) override;
  Result<std::unique_ptr<TcpListener>> listen_tcp(const Endpoint& local, TcpAccept accept,
                                                  ListenerFailed failed = nullptr) override;
  Result<std::unique_ptr<LocalStream>> open_local(const std::string& path, LocalCallbacks calls) override;
  Result<std::unique_ptr<LocalListener>> listen_local(const std::string& path, LocalAccept accept) override;
  Result<std::unique_ptr<ByteStream>> open_serial(const SerialOptions& options, StreamCallbacks calls) override;
  Result<std::unique_ptr<ByteStream>> make_pty(const std::string& link, StreamCallbacks calls) override;
  Result<std::unique_ptr<MqttLine>> open_mqtt(const MqttOptions& options, MqttCallbacks calls) override;
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done) override;
  Result<std::unique_ptr<Worker>> start_worker(const std::string& name) override;
  Result<std::unique_ptr<AppendFile>> open_append(const std::string& path) override;
  Result<void> rename_file(const std::string& from, const std::string& to) override;
  Result<void> remove_file(const std::string& path) override;
  Result<std::vector<std::string>> list_folder(const std::string& path) override;

 private:
  Loop* loop_ = nullptr;
  std::unique_ptr<NameLookup> names_;
  std::unique_ptr<MosquittoLines> mqtt_;  ///< made when first needed
};

}  // namespace rubicon::transport
