#include "networks/wsn/sink/stream_sinks.h"

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
                                                                transport::StreamCallbacks calls) {
  if (auto sockets = check_sockets(transports); !sockets) return fail(sockets.error());
  auto stream = std::make_unique<HostStream>(host, port, transports, std::move(calls));
  auto* const opened = stream.get();
  opened->lookup_ = transports.look_up(host, [opened](auto addresses) { opened->resolved(std::move(addresses)); });
  return stream;
}

HostStream::HostStream(std::string host, std::uint16_t port, transport::Transports& transports,
                       transport::StreamCallbacks calls)
    : host_(std::move(host)), port_(port), transports_(transports), callbacks_(std::move(calls)) {}

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
    transport::TcpCallbacks calls;
    calls.connected = [this] {
      connected_ = true;
      if (callbacks_.connected) callbacks_.connected();
    };
    calls.received = [this](ByteView bytes) {
      if (callbacks_.received) callbacks_.received(bytes);
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
  if (callbacks_.failed) callbacks_.failed(std::move(why));
}

Result<void> HostStream::send(ByteView bytes) {
  if (!tcp_ || !connected_) return fail(ErrorCode::kUnreachable, fmt::format("{}: not connected", host_));
  return tcp_->send(bytes);
}

void HostStream::hold(bool held) {
  held_ = held;
  if (tcp_) tcp_->hold(held);
}

namespace {

using Phase = SinkState::Phase;

constexpr std::string_view kNotAcknowledging = "the sink does not acknowledge";

SerialLink::Options link_options(const SinkOptions& options, std::uint8_t first_sequence) {
  SerialLink::Options link;
  link.greeting = options.greeting;
  link.first_sequence = first_sequence;
  return link;
}

}  // namespace

SerialSink::SerialSink(const SinkOptions& options, Scheduler& scheduler, transport::Transports& transports,
                       SinkCallbacks callbacks, std::uint8_t first_sequence)
    : source_(options.source),
      transports_(transports),
      notifier_(std::move(callbacks)),
      queue_(scheduler, options.lane_size, {[this] { link_.pump(); }, [this](Lane lane) { notifier_.room(lane); }}),
      link_(link_options(options, first_sequence), scheduler, queue_, notifier_, link_callbacks()),
      greets_(!options.greeting.empty()) {}

/// Write errors need no treatment: such a frame is not acknowledged, like one that got lost.
SerialLink::Callbacks SerialSink::link_callbacks() {
  SerialLink::Callbacks callbacks;
  callbacks.write = [this](ByteView bytes) {
    if (line_) (void)line_->send(bytes);
  };
  callbacks.unwritten = [this] { return line_ ? line_->queued() : std::size_t{0}; };
  callbacks.heard = [this] { (void)notifier_.set_state(Phase::kUp, {}); };
  callbacks.acknowledges = [this](bool acknowledges) { show_acknowledging(acknowledges); };
  callbacks.failed = [this](Error why) { lost(std::move(why)); };
  return callbacks;
}

Result<void> SerialSink::open() {
  if (notifier_.state().phase != Phase::kOff) return {};
  auto line = open_line();
  if (!line) return fail(line.error());
  line_ = std::move(*line);
  notifier_.connecting();
  return {};
}

Result<std::unique_ptr<transport::ByteStream>> SerialSink::open_line() {
  transport::StreamCallbacks calls;
  calls.connected = [this] {
    if (!greets_ && !notifier_.set_state(Phase::kUp, {})) return;
    link_.begin();
  };
  calls.received = [this](ByteView bytes) { link_.take(bytes); };
  calls.failed = [this](Error why) { lost(std::move(why)); };
  if (source_.kind == Source::Kind::kSerial)
    return transports_.open_serial({source_.path, source_.baud}, std::move(calls));
  return HostStream::open(source_.host, source_.port, transports_, std::move(calls));
}

void SerialSink::show_acknowledging(bool acknowledges) {
  if (notifier_.state().phase == Phase::kUp)
    (void)notifier_.set_state(Phase::kUp, acknowledges ? std::string() : std::string(kNotAcknowledging));
}

void SerialSink::lost(Error why) {
  const auto keep = std::move(line_);  // this call may come from it
  link_.end();
  (void)notifier_.failed({why.code, fmt::format("{}: {}", to_string(source_), why.text)});
}

std::map<std::string, std::uint64_t> SerialSink::counters() const {
  std::map<std::string, std::uint64_t> counters;
  notifier_.count(counters);
  queue_.count(counters);
  link_.count(counters);
  return counters;
}

ForwarderSink::ForwarderSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                             SinkCallbacks callbacks)
    : source_(options.source),
      greeting_(std::move(options.greeting)),
      scheduler_(scheduler),
      transports_(transports),
      notifier_(std::move(callbacks)),
      queue_(scheduler, options.lane_size, {[this] { pump(); }, [this](Lane lane) { notifier_.room(lane); }}) {}

Result<void> ForwarderSink::open() {
  if (notifier_.state().phase != Phase::kOff) return {};
  transport::StreamCallbacks calls;
  calls.connected = [this] { connected(); };
  calls.received = [this](ByteView bytes) { take(bytes); };
  calls.failed = [this](Error why) { lost(std::move(why)); };
  auto line = HostStream::open(source_.host, source_.port, transports_, std::move(calls));
  if (!line) return fail(line.error());
  line_ = std::move(*line);
  reader_ = {};
  notifier_.connecting();
  return {};
}

/// Both sides send their greeting immediately (wsn.md 4.1).
void ForwarderSink::connected() {
  if (const auto sent = line_->send(motes::kForwarderHello); !sent) return lost(sent.error());
  greeting_timeout_ = scheduler_.after(kGreetingTimeout, [this] {
    lost({ErrorCode::kUnreachable, "no greeting of the serial-forwarder protocol (55 20) within 10 s"});
  });
}

void ForwarderSink::take(ByteView bytes) {
  while (true) {
    const bool before = reader_.greeted();
    const auto packet = reader_.next(bytes);
    if (!before && reader_.greeted() && !greeted()) return;
    if (!packet) return lost(packet.error());
    if (!*packet) return;
    if (!notifier_.received(**packet)) return;
  }
}

/// False: this was destroyed, or the line is lost.
bool ForwarderSink::greeted() {
  greeting_timeout_.cancel();
  greeting_pending_ = !greeting_.empty();
  if (!notifier_.set_state(Phase::kUp, {})) return false;
  const auto self = lifetime_.watch();
  pump();
  return !self.ended() && line_ != nullptr;
}

/// False: pump() is called again later.
bool ForwarderSink::may_send() {
  if (gap_.pending()) return false;
  const auto now = scheduler_.now();
  const bool busy = line_->queued() > 0;  // further packets would only accumulate there
  if (now >= next_send_ && !busy) return true;
  gap_ = scheduler_.at(std::max(next_send_, busy ? now + kMinGap : now), [this] { pump(); });
  return false;
}

void ForwarderSink::pump() {
  if (notifier_.state().phase != Phase::kUp || !may_send()) return;
  const bool greets = std::exchange(greeting_pending_, false);
  Outgoing greeting;
  greeting.packet = greeting_;
  auto packet = greets ? std::optional(std::move(greeting)) : queue_.take();
  if (!packet) return;
  const auto sent = line_->send(motes::forwarder_packet(packet->packet));
  if (sent) return written(std::move(*packet));
  if (!greets) queue_.put_back(std::move(*packet));
  lost(sent.error());
}

void ForwarderSink::written(Outgoing packet) {
  ++written_;
  queue_.report(std::move(packet.done), SendResult::kAcknowledged);
  next_send_ = scheduler_.now() + kMinGap;
  gap_ = scheduler_.at(next_send_, [this] { pump(); });
  (void)notifier_.sent(packet.packet);
}

void ForwarderSink::lost(Error why) {
  const auto keep = std::move(line_);  // this call may come from it
  greeting_timeout_.cancel();
  gap_.cancel();
  (void)notifier_.failed({why.code, fmt::format("{}: {}", to_string(source_), why.text)});
}

std::map<std::string, std::uint64_t> ForwarderSink::counters() const {
  std::map<std::string, std::uint64_t> counters;
  notifier_.count(counters);
  queue_.count(counters);
  counters["acknowledged"] = written_;
  return counters;
}

}  // namespace rubicon::networks::wsn::sink
