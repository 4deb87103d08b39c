#include "networks/wsn/sink/serial_link.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "base/assert.h"

namespace rubicon::networks::wsn::sink {

namespace {

using motes::HdlcFaults;

struct FaultName {
  std::string_view name;
  std::uint64_t HdlcFaults::*count;
  std::string_view text;
};

constexpr std::array<FaultName, 6> kFaults{
    {{"bad-crc", &HdlcFaults::bad_crc, "a frame with a wrong CRC"},
     {"short-frames", &HdlcFaults::too_short, "a frame of less than 4 bytes"},
     {"long-frames", &HdlcFaults::too_long, "a frame of more than 256 bytes"},
     {"broken-escapes", &HdlcFaults::broken_escapes, "an escape byte before a flag"},
     {"unknown-protocols", &HdlcFaults::unknown_protocols,
      "a frame with an unknown protocol byte, expected 43, 44 or 45"},
     {"garbage-bytes", &HdlcFaults::bytes_between, "bytes outside frames"}}};

}  // namespace

SerialLink::SerialLink(Options options, Scheduler& scheduler, SendQueue& queue, SinkNotifier& notifier,
                       Callbacks callbacks)
    : options_(std::move(options)),
      scheduler_(scheduler),
      queue_(queue),
      notifier_(notifier),
      callbacks_(std::move(callbacks)),
      sequence_(options_.first_sequence) {
  RUBICON_ASSERT(options_.attempts >= 1 && options_.attempts <= 100 && options_.ack_timeout > Duration::zero());
}

void SerialLink::begin() {
  RUBICON_ASSERT(!up_);
  reader_.reset();
  earlier_ = reader_.faults();
  up_ = true;
  heard_ = false;
  unanswered_ = 0;
  if (options_.greeting.empty()) return pump();
  Flight greeting;
  greeting.packet.packet = options_.greeting;
  greeting.greeting = true;
  start(std::move(greeting));
}

void SerialLink::end() {
  up_ = false;
  ack_timeout_.cancel();
  auto flight = std::exchange(flight_, std::nullopt);
  if (!flight || flight->greeting || flight->acknowledged) return;
  interrupted_ = std::move(flight);
  if (!interrupted_->packet.repeatable || std::exchange(interrupted_->interrupted, true)) return drop_interrupted();
  expire_interrupted();
}

/// The packet may expire before there is a line again.
void SerialLink::expire_interrupted() {
  if (interrupted_->packet.expires == SteadyTime::max()) return;
  interrupted_expiry_ = scheduler_.at(interrupted_->packet.expires, [this] { drop_interrupted(); });
}

void SerialLink::drop_interrupted() {
  interrupted_expiry_.cancel();
  ++counters_.unacknowledged;
  queue_.report(std::move(interrupted_->packet.done), SendResult::kNotAcknowledged);
  interrupted_.reset();
}

// Receiving.

void SerialLink::take(ByteView bytes) {
  while (up_) {
    const auto frame = reader_.next(bytes);
    if (!frame) return void(note_faults());
    if (!take_frame(*frame)) return;
  }
}

/// False: this was destroyed. A frame is acknowledged before its packet is interpreted (wsn.md 2, rule 4).
bool SerialLink::take_frame(const motes::HdlcFrame& frame) {
  unanswered_ = 0;
  const auto self = lifetime_.watch();
  if (frame.protocol == motes::kHdlcAckedPacket) send_ack(frame.sequence);
  if (self.ended() || !note_first_frame()) return false;
  if (frame.protocol != motes::kHdlcAck) return notifier_.received(frame.packet);
  acknowledge(frame.sequence);
  return !self.ended();
}

void SerialLink::send_ack(std::uint8_t sequence) {
  if (callbacks_.unwritten() <= kMaxUnwritten) return callbacks_.write(motes::hdlc_ack(sequence));
  ++counters_.unsent_acks;
  (void)notifier_.note("unsent-acks", "the line takes no bytes: acknowledgements to the sink are not sent");
}

bool SerialLink::note_first_frame() {
  if (std::exchange(heard_, true)) return true;
  const auto self = lifetime_.watch();
  callbacks_.heard();
  return !self.ended();
}

bool SerialLink::note_faults() {
  const auto& faults = reader_.faults();
  if (faults == noted_) return true;
  const auto before = std::exchange(noted_, faults);
  const auto self = lifetime_.watch();
  for (const auto& fault : kFaults) {
    if (noted_.*fault.count == before.*fault.count) continue;
    if (!notifier_.note(std::string(fault.name), fault.text)) return false;
  }
  return !self.ended();
}

/// Acknowledgements of other packets are ignored (wsn.md 2). One of an earlier attempt shows that the sink has the
/// packet; the next packet still waits for the acknowledgement of the last attempt, because the sink may lose what
/// follows too soon (wsn.md 9.7).
void SerialLink::acknowledge(std::uint8_t sequence) {
  if (!flight_) return;
  const auto attempt = static_cast<std::uint8_t>(sequence - flight_->first);
  if (attempt >= flight_->attempts) return;
  const bool last = attempt + 1U == flight_->attempts;
  if (!std::exchange(flight_->acknowledged, true)) {
    ++counters_.acknowledged;
    queue_.report(std::move(flight_->packet.done), SendResult::kAcknowledged);
  }
  if (last) {
    flight_.reset();
    ack_timeout_.cancel();
  }
  const auto self = lifetime_.watch();
  callbacks_.acknowledges(true);
  if (!self.ended()) pump();
}

// Sending.

void SerialLink::pump() {
  if (!up_ || flight_) return;
  if (interrupted_ && interrupted_->packet.expires <= scheduler_.now()) drop_interrupted();
  if (interrupted_) {
    interrupted_expiry_.cancel();
    return start(*std::exchange(interrupted_, std::nullopt));
  }
  auto packet = queue_.take();
  if (!packet) return;
  Flight flight;
  flight.packet = std::move(*packet);
  start(std::move(flight));
}

void SerialLink::start(Flight flight) {
  flight.attempts = flight.blocked = 0;
  flight.first = sequence_;
  flight_ = std::move(flight);
  const bool first_time = !flight_->interrupted;
  attempt();
  if (first_time) notifier_.sent(Bytes(flight_->packet.packet));  // a copy: the callback may end the flight
}

void SerialLink::attempt() {
  ++flight_->attempts;
  flight_->blocked = 0;
  callbacks_.write(motes::hdlc_acked_packet(sequence_++, flight_->packet.packet));
  ack_timeout_ = scheduler_.after(options_.ack_timeout, [this] { ack_timed_out(); });
}

bool SerialLink::may_repeat() const {
  const auto& packet = flight_->packet;
  return packet.repeatable && flight_->attempts < options_.attempts && packet.expires > scheduler_.now();
}

/// No acknowledgement came in time. A frame that the line has not taken yet is not written again.
void SerialLink::ack_timed_out() {
  if (flight_->acknowledged) return next();
  if (callbacks_.unwritten() > 0) {
    if (++flight_->blocked >= options_.attempts)
      return callbacks_.failed({ErrorCode::kUnreachable, "the line takes no bytes"});
    ack_timeout_ = scheduler_.after(options_.ack_timeout, [this] { ack_timed_out(); });
    return;
  }
  if (!may_repeat()) return give_up();
  ++counters_.repeated;
  attempt();
}

void SerialLink::give_up() {
  ++counters_.unacknowledged;
  const auto attempts = flight_->attempts;
  if (flight_->greeting && !heard_) {
    const bool noise = reader_.faults() != earlier_;
    return callbacks_.failed(
        {ErrorCode::kUnreachable,
         fmt::format("the sink does not acknowledge: no answer to {} attempts{}", attempts,
                     noise ? "; only bytes that are not frames arrived: check the baud rate" : "")});
  }
  queue_.report(std::move(flight_->packet.done), SendResult::kNotAcknowledged);
  const auto self = lifetime_.watch();
  if (!notifier_.note("unacknowledged", fmt::format("the sink did not acknowledge a packet in {} attempts", attempts)))
    return;
  if (heard_ && ++unanswered_ >= kMaxUnanswered) {
    flight_.reset();
    return callbacks_.failed({ErrorCode::kUnreachable, "the sink stopped answering"});
  }
  callbacks_.acknowledges(false);
  if (!self.ended()) next();
}

void SerialLink::next() {
  flight_.reset();
  pump();
}

void SerialLink::count(std::map<std::string, std::uint64_t>& into) const {
  into["acknowledged"] = counters_.acknowledged;
  into["repeated-frames"] = counters_.repeated;
  into["unacknowledged"] = counters_.unacknowledged;
  into["unsent-acks"] = counters_.unsent_acks;
  for (const auto& fault : kFaults) into[std::string(fault.name)] = reader_.faults().*fault.count;
}

}  // namespace rubicon::networks::wsn::sink
