#include "networks/wsn/sink/host_stream.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::wsn::sink {

namespace {

/// Names can be resolved only where there are sockets. Connecting to an empty address fails before a socket is opened.
Result<void> check_sockets(transport::Transports& transports) {
  const auto tried = transports.open_tcp({}, {});
  if (!tried && tried.error().code == ErrorCode::kUnsupported) return fail(tried.error());
  return {};
}

}  // namespace

Result<std::unique_ptr<transport::ByteStream>> HostStream::open(const std::string& host, std::uint16_t port,
                                                                transport::Transports& transports,
                                                                transport::StreamCalls calls) {
  if (auto sockets = check_sockets(transports); !sockets) return fail(sockets.error());
  auto stream = std::make_unique<HostStream>(host, port, transports, std::move(calls));
  auto* const opened = stream.get();
  opened->lookup_ = transports.look_up(host, [opened](auto addresses) { opened->resolved(std::move(addresses)); });
  return stream;
}

HostStream::HostStream(std::string host, std::uint16_t port, transport::Transports& transports,
                       transport::StreamCalls calls)
    : host_(std::move(host)), port_(port), transports_(transports), calls_(std::move(calls)) {}

HostStream::~HostStream() = default;

void HostStream::resolved(Result<std::vector<std::string>> addresses) {
  const auto keep = std::move(lookup_);
  if (!addresses) return fail_with(addresses.error());
  untried_.assign(addresses->rbegin(), addresses->rend());
  connect_next({ErrorCode::kUnreachable, fmt::format("{} has no address", host_)});
}

/// `why`: the error if no address is left.
void HostStream::connect_next(Error why) {
  while (!untried_.empty()) {
    transport::TcpOptions options;
    options.remote = {std::move(untried_.back()), port_};
    untried_.pop_back();
    address_ = options.remote.address;
    transport::TcpCalls calls;
    calls.connected = [this] {
      connected_ = true;
      if (calls_.connected) calls_.connected();
    };
    calls.received = [this](ByteView bytes) {
      if (calls_.received) calls_.received(bytes);
    };
    calls.failed = [this](Error reason) { lost(std::move(reason)); };
    auto tcp = transports_.open_tcp(options, std::move(calls));
    if (tcp) {
      tcp_ = std::move(*tcp);
      tcp_->hold(held_);
      return;
    }
    why = tcp.error();
  }
  fail_with(std::move(why));
}

void HostStream::lost(Error why) {
  const auto keep = std::move(tcp_);  // this call comes from it
  if (connected_) return fail_with(std::move(why));
  connect_next(std::move(why));
}

/// The error of a lookup names the host already, that of a connection only the address.
void HostStream::fail_with(Error why) {
  if (!address_.empty() && address_ != host_) why.text = fmt::format("{}: {}", host_, why.text);
  if (calls_.failed) calls_.failed(std::move(why));
}

Result<void> HostStream::send(ByteView bytes) {
  if (!tcp_ || !connected_) return fail(ErrorCode::kUnreachable, fmt::format("{}: not connected", host_));
  return tcp_->send(bytes);
}

void HostStream::hold(bool held) {
  held_ = held;
  if (tcp_) tcp_->hold(held);
}

}  // namespace rubicon::networks::wsn::sink
