#pragma once

#include <memory>
#include <string_view>

#include "base/config_reader.h"
#include "support/fake_host.h"

namespace rubicon::contract {

/// What a network talks to, for those types that are silent alone.
class Peer {
 public:
  virtual ~Peer() = default;
};

/// The peer of a network of this type with these options, on the host's network of memory; nullptr if it needs none.
std::unique_ptr<Peer> peer_of(std::string_view type, const ConfigNode& options, const TypeCatalogue& types,
                              support::FakeHost& host);

/// The machine's files and the host's sockets of memory.
class DiskAndMemory final : public transport::Transports {
 public:
  explicit DiskAndMemory(transport::Transports& disk, transport::Transports& memory) : disk_(disk), memory_(memory) {}
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return disk_.open_file(path);
  }
  Result<std::unique_ptr<transport::UdpSocket>> open_udp(const transport::UdpOptions& options,
                                                         transport::UdpCallbacks calls) override {
    return memory_.open_udp(options, std::move(calls));
  }
  Result<std::unique_ptr<transport::TcpStream>> open_tcp(const transport::TcpOptions& options,
                                                         transport::TcpCallbacks calls) override {
    return memory_.open_tcp(options, std::move(calls));
  }
  Result<std::unique_ptr<transport::TcpListener>> listen_tcp(const transport::Endpoint& local,
                                                             transport::TcpAccept accept,
                                                             transport::ListenerFailed failed) override {
    return memory_.listen_tcp(local, std::move(accept), std::move(failed));
  }
  Result<std::unique_ptr<transport::ByteStream>> open_serial(const transport::SerialOptions& options,
                                                             transport::StreamCallbacks calls) override {
    return memory_.open_serial(options, std::move(calls));
  }
  Result<std::unique_ptr<transport::MqttLine>> open_mqtt(const transport::MqttOptions& options,
                                                         transport::MqttCallbacks calls) override {
    return memory_.open_mqtt(options, std::move(calls));
  }
  std::unique_ptr<transport::Lookup> look_up(const std::string& host, transport::LookupDone done) override {
    return memory_.look_up(host, std::move(done));
  }

 private:
  transport::Transports& disk_;
  transport::Transports& memory_;
};

}  // namespace rubicon::contract
