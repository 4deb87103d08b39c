#include "apps/simulators/motes/sink_port.h"

#include <utility>

namespace rubicon::motes_simulator {

SinkPort::SinkPort(SinkFirmware& sink, const EventLog& log) : sink_(sink), log_(log) {
  sink_.connect([this](ByteView bytes) {
    // Bytes that the computer does not read are lost, as on a real line.
    if (stream_ && stream_->queued() == 0) static_cast<void>(stream_->send(bytes).has_value());
  });
  sink_.on_room([this] {
    if (stream_) stream_->hold(false);
  });
}

SinkPort::~SinkPort() {
  sink_.connect({});
  sink_.on_room({});
}

Result<void> SinkPort::open(Opener opener) {
  opener_ = std::move(opener);
  return plug();
}

Result<void> SinkPort::plug() {
  if (!opener_ || reachable_) return {};
  auto opened = opener_(*this);
  if (!opened) return fail(opened.error());
  reachable_ = std::move(*opened);
  return {};
}

void SinkPort::pull() {
  reachable_.reset();
  if (stream_) lost();
}

transport::StreamCallbacks SinkPort::take(std::unique_ptr<transport::ByteStream> stream) {
  if (stream_) {
    if (log_) log_({{}, "refused", sink_.number(), 0, std::nullopt, std::nullopt, {}});
    return {};
  }
  attach(std::move(stream));
  return calls();
}

void SinkPort::attach(std::unique_ptr<transport::ByteStream> stream) {
  stream_ = std::move(stream);
  if (sink_.congested()) stream_->hold(true);
  if (log_) log_({{}, "connected", sink_.number(), 0, std::nullopt, std::nullopt, {}});
  if (connected_) connected_();
}

transport::StreamCallbacks SinkPort::calls() {
  transport::StreamCallbacks calls;
  calls.received = [this](ByteView bytes) { received(bytes); };
  calls.failed = [this](const Error&) { lost(); };
  return calls;
}

void SinkPort::received(ByteView bytes) {
  sink_.received(bytes);
  if (stream_ && sink_.congested()) stream_->hold(true);
}

void SinkPort::lost() {
  const auto gone = std::move(stream_);
  sink_.disconnected();
  if (log_) log_({{}, "disconnected", sink_.number(), 0, std::nullopt, std::nullopt, {}});
}

void SinkPort::closed() {
  reachable_.reset();
  if (closed_) closed_();
}

SinkPort::Opener on_tcp(transport::Transports& transports, transport::Endpoint at,
                        std::function<void(const transport::Endpoint&)> bound) {
  return [&transports, at = std::move(at), bound = std::move(bound)](SinkPort& port) -> Result<std::shared_ptr<void>> {
    auto listening = transports.listen_tcp(
        at, [&port](auto stream) { return port.take(std::move(stream)); }, [&port](const Error&) { port.closed(); });
    if (!listening) return fail(listening.error());
    if (bound) bound((*listening)->local());
    return std::shared_ptr<transport::TcpListener>(std::move(*listening));
  };
}

SinkPort::Opener on_pty(transport::Transports& transports, std::string link) {
  return [&transports, link = std::move(link)](SinkPort& port) -> Result<std::shared_ptr<void>> {
    auto calls = port.calls();
    calls.failed = [&port](const Error&) {
      port.lost();
      port.closed();
    };
    auto stream = transports.make_pty(link, std::move(calls));
    if (!stream) return fail(stream.error());
    port.attach(std::move(*stream));
    return std::make_shared<int>(0);
  };
}

}  // namespace rubicon::motes_simulator
