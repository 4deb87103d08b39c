#include "networks/knx/line/routing_line.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::knx::line {

using transport::Endpoint;

RoutingLine::RoutingLine(Scheduler& scheduler, transport::Transports& transports, RoutingOptions options,
                         LineCallbacks callbacks, RoutingCallbacks routing_callbacks)
    : scheduler_(scheduler),
      transports_(transports),
      options_(std::move(options)),
      callbacks_(std::move(callbacks)),
      routing_callbacks_(std::move(routing_callbacks)),
      silence_(scheduler, [this] { rejoin(); }),
      routing_(scheduler,
               {options_.address, std::chrono::milliseconds(20), options_.seed, options_.limits, options_.guard},
               routing_calls()) {
  state_.server = to_string(options_.group);
  if (!options_.interface_address.empty()) state_.server += " on " + options_.interface_address;
  state_.own = options_.address;
}

Routing::Callbacks RoutingLine::routing_calls() {
  Routing::Callbacks calls;
  calls.send = [this](ByteView frame) { return transmit(frame); };
  calls.received = [this](const wire::Telegram& telegram) {
    if (callbacks_.received) callbacks_.received(telegram);
  };
  calls.note = callbacks_.note;
  calls.frame = [this](ByteView cemi, bool outgoing) {
    if (callbacks_.frame) callbacks_.frame(cemi, outgoing);
  };
  calls.lost = [this](const Endpoint& from, const wire::RoutingLostMessage& message) {
    if (routing_callbacks_.lost) routing_callbacks_.lost(from, message);
  };
  calls.discovery = [this](const Endpoint& from, ByteView frame) {
    if (routing_callbacks_.discovery) routing_callbacks_.discovery(from, frame);
  };
  calls.changed = [this] { report_state(); };
  calls.failed = [this](Error error) { lost(std::move(error)); };
  return calls;
}

Result<void> RoutingLine::open() {
  routing_.down();
  close_later_.cancel();
  close();
  auto opened = join_all();
  if (opened) opened = open_sender();
  if (opened) opened = make_guard();
  if (!opened) {
    close();
    return opened;
  }
  sockets_open();
  return {};
}

void RoutingLine::sockets_open() {
  silence_.set(kSilence);
  if (!guard_) return become_up();
  state_.phase = LineState::Phase::kConnecting;
  state_.reason = "asks the secure routing group for its timer";
  report_up_ = scheduler_.after(Duration::zero(), [this] {
    if (callbacks_.changed) callbacks_.changed(state_);
  });
  guard_->start();
}

void RoutingLine::become_up() {
  routing_.up({options_.interface_address, sender_->local().port});
  state_.phase = LineState::Phase::kUp;
  report_up_ = scheduler_.after(Duration::zero(), [this] { report_state(); });
}

Result<void> RoutingLine::make_guard() {
  if (!options_.secure || guard_) return {};
  secure::RoutingGuard::Callbacks calls;
  calls.transmit = [this](ByteView datagram) { std::ignore = sender_->send(options_.group, datagram); };
  calls.synchronised = [this] {
    if (state_.phase == LineState::Phase::kConnecting) become_up();
  };
  // The line may be destroyed in a note, but not in a call of its guard.
  calls.note = [this](std::string_view subject, std::string_view text) {
    if (!callbacks_.note) return;
    lifetime_.post(scheduler_, [this, subject = std::string(subject), text = std::string(text)] {
      callbacks_.note(subject, text);
    });
  };
  auto made =
      secure::RoutingGuard::make(scheduler_, *options_.secure, options_.storage, options_.random, std::move(calls));
  if (!made) return fail(made.error());
  guard_ = std::move(*made);
  return {};
}

Result<void> RoutingLine::transmit(ByteView frame) {
  if (!guard_) return sender_->send(options_.group, frame);
  const auto wrapped = guard_->wrap(frame);
  return wrapped ? sender_->send(options_.group, *wrapped) : Result<void>(fail(wrapped.error()));
}

Result<void> RoutingLine::join_all() {
  if (options_.group.address == kKnxGroup) return join(options_.group, Routing::Group::kOnly);
  auto joined = join(options_.group, Routing::Group::kConfigured);
  if (joined) joined = join({std::string(kKnxGroup), options_.group.port}, Routing::Group::kSystem);
  return joined;
}

/// Bound to the group address, so that a server on this machine still receives what is sent to its port.
Result<void> RoutingLine::join(const Endpoint& group, Routing::Group role) {
  transport::UdpOptions options{group};
  options.multicast = transport::UdpMulticast{{group.address}, options_.interface_address, options_.ttl};
  options.reuse_address = true;
  transport::UdpCallbacks calls;
  calls.received = [this, role](const Endpoint& from, ByteView bytes) { receive(from, bytes, role); };
  calls.undelivered = [](const Error&) {};
  calls.failed = [this](Error error) { lost(std::move(error)); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return fail(socket.error());
  sockets_.push_back(std::move(*socket));
  return {};
}

/// Other programs of this machine receive the group on the same port. Sending from another port lets them and this
/// program tell their frames apart (measured: knxd takes all frames from its address and port 3671 for its own).
Result<void> RoutingLine::open_sender() {
  transport::UdpOptions options{{options_.interface_address, 0}};
  options.multicast = transport::UdpMulticast{{}, options_.interface_address, options_.ttl};
  transport::UdpCallbacks calls;
  calls.received = [](const Endpoint&, ByteView) {};
  calls.undelivered = [](const Error&) {};  // one datagram to a group; lasting errors show when sending
  calls.failed = [this](Error error) { lost(std::move(error)); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return fail(socket.error());
  sender_ = std::move(*socket);
  return {};
}

void RoutingLine::receive(const Endpoint& from, ByteView datagram, Routing::Group role) {
  if (from.port != sender_->local().port) silence_.set(kSilence);  // own frames do not prove membership
  if (!guard_) return routing_.receive(from, datagram, role);
  // With a group of its own the line has no business with what other installations send to the system group.
  if (role == Routing::Group::kSystem && !secure::RoutingGuard::is_discovery(datagram)) return;
  const auto watch = lifetime_.watch();
  const auto frame = guard_->receive(transport::to_string(from), datagram);
  if (state_.phase == LineState::Phase::kUp && guard_->problem() != shown_problem_) {
    report_state();
    if (watch.ended()) return;
  }
  if (!frame.empty()) routing_.receive(from, frame, role);
}

/// Leaves and joins: only that makes the system report the membership to the switch. Sockets and received data stay.
void RoutingLine::rejoin() {
  ++rejoined_;
  for (const auto& socket : sockets_) {
    if (auto joined = socket->rejoin(); !joined) return lost(joined.error());
  }
  silence_.set(kSilence);
}

std::map<std::string, std::uint64_t> RoutingLine::counters() const {
  auto all = routing_.counters();
  all["joined-again"] = rejoined_;
  if (guard_) all.merge(guard_->counters());
  return all;
}

void RoutingLine::close() {
  silence_.clear();
  if (guard_) guard_->stop();
  sockets_.clear();
  sender_.reset();
}

void RoutingLine::send(wire::Telegram telegram, SteadyTime expires, SendCallback done) {
  routing_.send(std::move(telegram), expires, after_settled(std::move(done), callbacks_));
}

/// The sockets are closed in a later turn: this may be a call of one of them.
void RoutingLine::lost(Error why) {
  routing_.down();
  if (guard_) guard_->stop();
  silence_.clear();
  state_.phase = LineState::Phase::kOff;
  state_.reason = why.text;
  state_.finding = why.finding;
  close_later_ = scheduler_.after(Duration::zero(), [this, why = std::move(why)] { report_lost(why); });
}

void RoutingLine::report_lost(const Error& why) {
  close();
  const auto watch = lifetime_.watch();
  const auto copy = why;  // the timer that owns `why` may be destroyed with this
  if (callbacks_.changed) callbacks_.changed(state_);
  if (!watch.ended() && callbacks_.failed) callbacks_.failed(copy);
}

void RoutingLine::report_state() {
  if (state_.phase != LineState::Phase::kUp) return;
  state_.reason = routing_.problem();
  shown_problem_ = guard_ ? guard_->problem() : "";
  state_.finding = {};
  if (state_.reason.empty() && guard_) {
    state_.reason = shown_problem_;
    state_.finding = guard_->finding();
  }
  if (callbacks_.changed) callbacks_.changed(state_);
}

}  // namespace rubicon::networks::knx::line
