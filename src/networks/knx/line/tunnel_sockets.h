#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/line/tunnel.h"
#include "networks/knx/wire/frame.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::line {

/// Cuts a stream of bytes into frames by their total length (knx.md, section 3). Holds at most one
/// incomplete frame.
class FrameStream {
 public:
  /// Far longer than any frame of the services over TCP: a header with a larger length is an error.
  static constexpr std::size_t kMaxFrame = 2048;

  /// Adds received bytes; only after next() has returned an empty view.
  void append(ByteView bytes);
  /// The next whole frame, valid until the next call to this; empty if it is incomplete. kInvalid: the stream is broken
  /// and must be closed.
  Result<ByteView> next();
  void clear();

 private:
  Bytes buffer_;
  std::size_t begin_ = 0;
};

/// Of a numeric address.
inline bool is_ipv4(const std::string& address) {
  return address.find(':') == std::string::npos;
}

/// The socket of a tunnel, UDP or TCP: turns what comes into whole frames and sends frames to the endpoints of the
/// server. Part of TunnelLine. Each callback is the last action of the function that makes it, so this may be closed
/// or destroyed in it.
class TunnelSockets {
 public:
  struct Settings {
    bool stream = false;           ///< TCP
    std::uint16_t local_port = 0;  ///< of UDP; 0 = any
  };

  struct Callbacks {
    std::function<void()> connected;  ///< of a stream
    std::function<void(ByteView frame)> received;
    /// A datagram came from another host and was ignored.
    std::function<void()> stranger;
    /// The operating system reports that a datagram could not be delivered.
    std::function<void()> undelivered;
    /// Nothing more will come; kInvalid: the server sends no KNXnet/IP.
    std::function<void(const Error&)> failed;
  };

  /// The transports must outlive it.
  TunnelSockets(Settings settings, transport::Transports& transports, Callbacks callbacks);

  /// A socket to the control endpoint of the server. `finds_own`: own() will be our address as that server sees it.
  Result<void> open(const transport::Endpoint& control, bool finds_own);
  /// Tries whether there are sockets and the local port is free.
  Result<void> try_open() const;
  void close();
  /// Closes a stream without sending what the operating system still holds.
  void abort();
  bool is_open() const { return socket_ != nullptr || stream_ != nullptr; }

  /// A frame that cannot be sent is treated as lost; send_error() tells why. False: the system cannot send a datagram
  /// to the server (no route, no such address of ours), so that no answer will come.
  bool send(Tunnel::Path path, ByteView frame);
  /// Route back: that of the control endpoint.
  void set_data_endpoint(const wire::Hpai& data);
  const transport::Endpoint& control_endpoint() const { return control_; }
  /// Where the server may send: route back over TCP, or if the own address was not asked for.
  wire::Hpai own() const;

  /// Of the last failed send since something was received.
  const std::string& send_error() const { return send_error_; }
  /// The last sender that is not the server, since open(); empty = none.
  const std::string& stranger() const { return stranger_; }

 private:
  Result<void> open_udp();
  Result<void> open_tcp();
  void datagram(const transport::Endpoint& from, ByteView bytes);
  void stream_received(ByteView bytes);

  Settings settings_;
  transport::Transports& transports_;
  Callbacks callbacks_;
  transport::Endpoint control_, data_;  ///< of the server
  bool finds_own_ = false;
  std::unique_ptr<transport::UdpSocket> socket_;
  std::unique_ptr<transport::TcpStream> stream_;
  FrameStream frames_;
  std::string send_error_, stranger_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx::line
