#include "networks/knx/line/routing_line.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::knx::line {

using transport::Endpoint;

RoutingLine::RoutingLine(Scheduler& scheduler, transport::Transports& transports, RoutingOptions options,
                         LineCalls calls, RoutingCalls more)
    : scheduler_(scheduler),
      transports_(transports),
      options_(std::move(options)),
      calls_(std::move(calls)),
      more_(std::move(more)),
      silence_(scheduler, [this] { join_again(); }),
      machine_(scheduler, {options_.address, std::chrono::milliseconds(20), options_.seed, options_.limits},
               machine_calls()) {
  state_.server = to_string(options_.group);
  if (!options_.interface_address.empty()) state_.server += " on " + options_.interface_address;
  state_.own = options_.address;
}

RoutingLine::~RoutingLine() {
  *alive_ = false;
}

Routing::Calls RoutingLine::machine_calls() {
  Routing::Calls calls;
  calls.send = [this](ByteView frame) { return sender_->send(options_.group, frame); };
  calls.received = [this](const wire::Telegram& telegram) {
    if (calls_.received) calls_.received(telegram);
  };
  calls.note = calls_.note;
  calls.frame = [this](ByteView cemi, bool outgoing) {
    if (calls_.frame) calls_.frame(cemi, outgoing);
  };
  calls.lost = [this](const Endpoint& from, const wire::RoutingLostMessage& message) {
    if (more_.lost) more_.lost(from, message);
  };
  calls.discovery = [this](const Endpoint& from, ByteView frame) {
    if (more_.discovery) more_.discovery(from, frame);
  };
  calls.changed = [this] { tell(); };
  calls.failed = [this](Error error) { lost(std::move(error)); };
  return calls;
}

Result<void> RoutingLine::open() {
  machine_.down();
  closing_.cancel();
  close();
  auto opened = join_all();
  if (opened) opened = open_sender();
  if (!opened) {
    close();
    return opened;
  }
  machine_.up({options_.interface_address, sender_->local().port});
  silence_.set(kSilence);
  state_.phase = LineState::Phase::kUp;
  up_ = scheduler_.after(Duration::zero(), [this] { tell(); });
  return {};
}

Result<void> RoutingLine::join_all() {
  if (options_.group.address == kKnxGroup) return join(options_.group, Routing::Group::kOnly);
  auto joined = join(options_.group, Routing::Group::kConfigured);
  if (joined) joined = join({std::string(kKnxGroup), options_.group.port}, Routing::Group::kSystem);
  return joined;
}

/// Bound to the group, so that a server on this machine keeps what is sent to its port.
Result<void> RoutingLine::join(const Endpoint& group, Routing::Group role) {
  transport::UdpOptions options{group};
  options.multicast = transport::UdpMulticast{{group.address}, options_.interface_address, options_.ttl};
  options.reuse_address = true;
  transport::UdpCalls calls;
  calls.received = [this, role](const Endpoint& from, ByteView bytes) { heard(from, bytes, role); };
  calls.undelivered = [](const Error&) {};
  calls.failed = [this](Error error) { lost(std::move(error)); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return fail(socket.error());
  sockets_.push_back(std::move(*socket));
  return {};
}

/// Others on this machine hear the group on the same port; from a port of our own they know our frames from theirs, as
/// we do (knxd takes for its own what comes from its address and port 3671: measured).
Result<void> RoutingLine::open_sender() {
  transport::UdpOptions options{{options_.interface_address, 0}};
  options.multicast = transport::UdpMulticast{{}, options_.interface_address, options_.ttl};
  transport::UdpCalls calls;
  calls.received = [](const Endpoint&, ByteView) {};
  calls.undelivered = [](const Error&) {};  // of one datagram to a group; what matters shows when sending
  calls.failed = [this](Error error) { lost(std::move(error)); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return fail(socket.error());
  sender_ = std::move(*socket);
  return {};
}

void RoutingLine::heard(const Endpoint& from, ByteView datagram, Routing::Group role) {
  if (from.port != sender_->local().port) silence_.set(kSilence);  // what we hear of ourselves proves nothing
  machine_.heard(from, datagram, role);
}

/// Left and joined: only that makes the system say so to the switch. The sockets stay, and what has come to them.
void RoutingLine::join_again() {
  ++joined_again_;
  for (const auto& socket : sockets_) {
    if (auto joined = socket->rejoin(); !joined) return lost(joined.error());
  }
  silence_.set(kSilence);
}

std::map<std::string, std::uint64_t> RoutingLine::counters() const {
  auto all = machine_.counters();
  all["joined-again"] = joined_again_;
  return all;
}

void RoutingLine::close() {
  silence_.clear();
  sockets_.clear();
  sender_.reset();
}

void RoutingLine::send(wire::Telegram telegram, SteadyTime expires, SentCall done) {
  machine_.send(std::move(telegram), expires, telling(std::move(done), calls_));
}

/// The sockets live until a later turn: one of them may be calling.
void RoutingLine::lost(Error why) {
  machine_.down();
  silence_.clear();
  state_.phase = LineState::Phase::kOff;
  state_.reason = why.text;
  closing_ = scheduler_.after(Duration::zero(), [this, why = std::move(why)] { tell_lost(why); });
}

void RoutingLine::tell_lost(const Error& why) {
  close();
  const auto alive = alive_;
  const auto copy = why;  // whose owner may be destroyed
  if (calls_.changed) calls_.changed(state_);
  if (*alive && calls_.failed) calls_.failed(copy);
}

void RoutingLine::tell() {
  if (state_.phase != LineState::Phase::kUp) return;
  state_.reason = machine_.note();
  if (calls_.changed) calls_.changed(state_);
}

}  // namespace rubicon::networks::knx::line
