#include "networks/knx/line/tunnel_sockets.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::knx::line {

void FrameStream::append(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<ByteView> FrameStream::next() {
  const auto rest = ByteView(buffer_).subspan(begin_);
  const auto size = wire::frame_size(rest);
  if (!size) return fail(size.error());
  if (*size > kMaxFrame)
    return fail(ErrorCode::kInvalid, fmt::format("KNXnet/IP total length {}, expected at most {}", *size, kMaxFrame));
  if (*size == 0 || *size > rest.size()) return ByteView{};
  begin_ += *size;
  return rest.first(*size);
}

void FrameStream::clear() {
  buffer_.clear();
  begin_ = 0;
}

namespace {

constexpr std::size_t kMaxDatagram = 2048;

transport::UdpCallbacks no_calls() {
  return {[](const auto&, ByteView) {}, [](const Error&) {}, [](const Error&) {}};
}

}  // namespace

TunnelSockets::TunnelSockets(Settings settings, transport::Transports& transports, Callbacks callbacks)
    : settings_(settings), transports_(transports), callbacks_(std::move(callbacks)) {}

Result<void> TunnelSockets::try_open() const {
  transport::UdpOptions trial;
  if (!settings_.stream) trial.local.port = settings_.local_port;
  if (const auto tried = transports_.open_udp(trial, no_calls()); !tried) return fail(tried.error());
  return {};
}

Result<void> TunnelSockets::open(const transport::Endpoint& control, bool finds_own) {
  control_ = data_ = control;
  finds_own_ = finds_own;
  send_error_.clear();
  stranger_.clear();
  return settings_.stream ? open_tcp() : open_udp();
}

/// A connected probe socket tells which of our addresses the server sees. The socket of the tunnel is not connected,
/// since the data endpoint of a server may be another address. It is bound to our address with route back too: without
/// that address it cannot send, while another one, which the server does not know, would get no answer.
Result<void> TunnelSockets::open_udp() {
  transport::UdpOptions options, probe;
  probe.remote = control_;
  {
    const auto found = transports_.open_udp(probe, no_calls());
    if (!found) return fail(found.error());
    options.local = (*found)->local();
  }
  if (!is_ipv4(options.local.address)) options.local.address.clear();
  options.local.port = settings_.local_port;
  options.largest = kMaxDatagram;
  transport::UdpCallbacks calls;
  calls.received = [this](const transport::Endpoint& from, ByteView bytes) { datagram(from, bytes); };
  calls.undelivered = [this](const Error&) { callbacks_.undelivered(); };
  calls.failed = [this](const Error& error) { callbacks_.failed(error); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return fail(socket.error());
  socket_ = std::move(*socket);
  return {};
}

Result<void> TunnelSockets::open_tcp() {
  frames_.clear();
  transport::TcpOptions options;
  options.remote = control_;
  transport::TcpCallbacks calls;
  calls.connected = [this] { callbacks_.connected(); };
  calls.received = [this](ByteView bytes) { stream_received(bytes); };
  calls.failed = [this](const Error& error) { callbacks_.failed(error); };
  auto stream = transports_.open_tcp(options, std::move(calls));
  if (!stream) return fail(stream.error());
  stream_ = std::move(*stream);
  return {};
}

void TunnelSockets::close() {
  socket_.reset();
  stream_.reset();
}

void TunnelSockets::abort() {
  if (stream_) stream_->abort();
  close();
}

wire::Hpai TunnelSockets::own() const {
  if (settings_.stream) return {wire::HostProtocol::kTcp, {}, 0};
  if (!finds_own_ || !socket_) return {};
  const auto local = socket_->local();
  const auto own = wire::udp_hpai(local.address, local.port);
  return own.route_back() ? wire::Hpai{} : own;
}

void TunnelSockets::set_data_endpoint(const wire::Hpai& data) {
  if (!settings_.stream && !data.route_back()) data_ = {address_text(data), data.port};
}

bool TunnelSockets::send(Tunnel::Path path, ByteView frame) {
  Result<void> sent;
  if (stream_) {
    sent = stream_->send(frame);
  } else if (socket_) {
    sent = socket_->send(path == Tunnel::Path::kData ? data_ : control_, frame);
  }
  if (!sent) send_error_ = sent.error().text;
  return sent || stream_ || sent.error().code != ErrorCode::kIo;
}

/// Accepts datagrams of the server, from any port.
void TunnelSockets::datagram(const transport::Endpoint& from, ByteView bytes) {
  if (from.address != control_.address && from.address != data_.address) {
    stranger_ = transport::to_string(from);
    return callbacks_.stranger();
  }
  send_error_.clear();
  callbacks_.received(bytes);
}

void TunnelSockets::stream_received(ByteView bytes) {
  const auto watch = lifetime_.watch();
  frames_.append(bytes);
  while (!watch.ended() && stream_) {
    const auto frame = frames_.next();
    if (!frame) return callbacks_.failed(frame.error());
    if (frame->empty()) return;
    callbacks_.received(*frame);
  }
}

}  // namespace rubicon::networks::knx::line
