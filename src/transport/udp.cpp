#include "transport/udp.h"

#include <fmt/format.h>

#include "base/assert.h"
#include "transport/transports.h"

namespace rubicon::transport {

std::string to_string(const Endpoint& endpoint) {
  const bool six = endpoint.address.find(':') != std::string::npos;
  return six ? fmt::format("[{}]:{}", endpoint.address, endpoint.port)
             : fmt::format("{}:{}", endpoint.address.empty() ? "*" : endpoint.address, endpoint.port);
}

// NOLINTBEGIN(performance-unnecessary-value-param): those that have sockets keep what they are given
Result<std::unique_ptr<UdpSocket>> Transports::open_udp(const UdpOptions&, UdpCalls) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

Result<std::unique_ptr<TcpStream>> Transports::open_tcp(const TcpOptions&, TcpCalls) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

Result<std::unique_ptr<TcpListener>> Transports::listen_tcp(const Endpoint&, TcpAccept, ListenerFailed) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

Result<std::unique_ptr<ByteStream>> Transports::open_serial(const SerialOptions&, StreamCalls) {
  return fail(ErrorCode::kUnsupported, "this transport has no serial lines");
}

Result<std::unique_ptr<ByteStream>> Transports::make_pty(const std::string&, StreamCalls) {
  return fail(ErrorCode::kUnsupported, "this transport has no serial lines");
}

Result<std::unique_ptr<MqttLine>> Transports::open_mqtt(const MqttOptions&, MqttCalls) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

std::unique_ptr<Lookup> Transports::look_up(const std::string&, LookupDone) {
  base::assertion_failed("names are looked up where there are sockets", __FILE__, __LINE__);
}
// NOLINTEND(performance-unnecessary-value-param)

}  // namespace rubicon::transport
