#pragma once

#include <memory>
#include <string>
#include <vector>

#include "transport/transports.h"

namespace rubicon::networks::wsn::sink {

/// A TCP connection to a host name: resolves the name, then tries its addresses in order. Destroying it cancels or
/// closes the connection. Callbacks as of any stream; each may destroy it.
class HostStream final : public transport::ByteStream {
 public:
  /// kUnsupported where there are no sockets.
  static Result<std::unique_ptr<ByteStream>> open(const std::string& host, std::uint16_t port,
                                                  transport::Transports& transports, transport::StreamCalls calls);
  HostStream(std::string host, std::uint16_t port, transport::Transports& transports, transport::StreamCalls calls);
  ~HostStream() override;
  HostStream(const HostStream&) = delete;
  HostStream& operator=(const HostStream&) = delete;

  /// kUnreachable before it is connected.
  Result<void> send(ByteView bytes) override;
  void hold(bool held) override;
  std::size_t queued() const override { return tcp_ ? tcp_->queued() : 0; }

 private:
  void resolved(Result<std::vector<std::string>> addresses);
  void connect_next(Error why);
  void lost(Error why);
  void fail_with(Error why);

  std::string host_;
  std::uint16_t port_;
  transport::Transports& transports_;
  transport::StreamCalls calls_;
  std::unique_ptr<transport::Lookup> lookup_;
  std::vector<std::string> untried_;  ///< addresses, the next one last
  std::string address_;               ///< the last one tried
  std::unique_ptr<transport::TcpStream> tcp_;
  bool connected_ = false;
  bool held_ = false;
};

}  // namespace rubicon::networks::wsn::sink
