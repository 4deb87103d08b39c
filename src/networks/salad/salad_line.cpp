#include "networks/salad/salad_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::salad {

SaladLine::SaladLine(const SaladOptions& options, transport::Transports& transports, Callbacks callbacks)
    : options_(options), transports_(transports), callbacks_(std::move(callbacks)) {}

Result<void> SaladLine::open() {
  if (receiver_) {
    if (ready_) callbacks_.ready();
    return {};
  }
  if (auto opened = open_sockets(); !opened) {
    close();
    return opened;
  }
  look_up();
  return {};
}

Result<void> SaladLine::open_sockets() {
  transport::UdpCallbacks calls;
  calls.received = [this](const transport::Endpoint& from, ByteView bytes) { receive(from, bytes); };
  calls.undelivered = [](const Error&) {};
  calls.failed = [this](Error why) { fail_line(std::move(why)); };
  auto receiver = transports_.open_udp({{"", options_.own_port}, options_.buffer}, calls);
  if (!receiver) return fail(receiver.error());
  receiver_ = std::move(*receiver);
  calls.received = [](const transport::Endpoint&, ByteView) {};
  calls.undelivered = [this](const Error& error) {
    ++counters_.undelivered;
    callbacks_.undelivered(error);
  };
  auto sender = transports_.open_udp({{}, options_.buffer}, std::move(calls));
  if (!sender) return fail(sender.error());
  sender_ = std::move(*sender);
  return {};
}

void SaladLine::close() {
  unsent_ = unsent();
  ready_ = false;
  lookup_.reset();
  receiver_.reset();
  sender_.reset();
  addresses_.clear();
}

void SaladLine::refresh() {
  if (ready_ && !lookup_) look_up();
}

void SaladLine::look_up() {
  lookup_ = transports_.look_up(options_.host, [this](auto addresses) { looked_up(std::move(addresses)); });
}

void SaladLine::looked_up(Result<std::vector<std::string>> addresses) {
  lookup_.reset();
  if (!addresses && ready_) return callbacks_.undelivered(addresses.error());
  if (!addresses) return fail_line(std::move(addresses.error()));
  addresses_ = std::move(*addresses);
  if (!std::exchange(ready_, true)) callbacks_.ready();
}

void SaladLine::fail_line(Error why) {
  close();
  callbacks_.failed(std::move(why));
}

/// Only the host is checked: SALAD may send from any port.
void SaladLine::receive(const transport::Endpoint& from, ByteView bytes) {
  const bool known = std::find(addresses_.begin(), addresses_.end(), from.address) != addresses_.end();
  if (!known && !options_.any_source) {
    ++counters_.other_source;
    return callbacks_.counted();
  }
  ++counters_.datagrams;
  callbacks_.received(bytes);
}

Result<void> SaladLine::send(std::string_view datagram) {
  if (!ready_) return fail(ErrorCode::kUnreachable, fmt::format("the line to SALAD at {} is not open", options_.host));
  return sender_->send({addresses_.front(), options_.port}, base::as_bytes(datagram));
}

}  // namespace rubicon::networks::salad
