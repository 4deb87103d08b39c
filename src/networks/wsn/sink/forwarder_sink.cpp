#include "networks/wsn/sink/forwarder_sink.h"

#include <fmt/format.h>

#include <utility>

#include "networks/wsn/sink/host_stream.h"

namespace rubicon::networks::wsn::sink {

namespace {

using Phase = SinkState::Phase;

}  // namespace

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
  transport::StreamCalls calls;
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
