#include "networks/wsn/sink/serial_sink.h"

#include <fmt/format.h>

#include <utility>

#include "networks/wsn/sink/host_stream.h"

namespace rubicon::networks::wsn::sink {

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
  transport::StreamCalls calls;
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

}  // namespace rubicon::networks::wsn::sink
