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
     {"broken-escapes", &HdlcFaults::broken_escapes, "an escape before a flag"},
     {"unknown-protocols", &HdlcFaults::unknown_protocols, "a frame of unknown protocol, expected 43, 44 or 45"},
     {"garbage-bytes", &HdlcFaults::bytes_between, "bytes outside of frames"}}};

}  // namespace

SerialLink::SerialLink(Options options, Scheduler& scheduler, SendQueue& queue, SinkNotifier& notifier, Calls calls)
    : options_(std::move(options)),
      scheduler_(scheduler),
      queue_(queue),
      notifier_(notifier),
      calls_(std::move(calls)),
      sequence_(options_.first_sequence) {
  RUBICON_ASSERT(options_.attempts >= 1 && options_.attempts <= 100 && options_.ack_timeout > Duration::zero());
}

void SerialLink::begin() {
  RUBICON_ASSERT(!up_);
  reader_.reset();
  before_ = reader_.faults();
  up_ = true;
  heard_ = false;
  unheard_ = 0;
  if (options_.greeting.empty()) return pump();
  Flight greeting;
  greeting.packet.packet = options_.greeting;
  greeting.greeting = true;
  start(std::move(greeting));
}

void SerialLink::end() {
  up_ = false;
  ack_.cancel();
  auto flight = std::exchange(flight_, std::nullopt);
  if (!flight || flight->greeting || flight->acknowledged) return;
  kept_ = std::move(flight);
  if (!kept_->packet.repeatable || std::exchange(kept_->again, true)) return drop_kept();
  watch_kept();
}

/// Its time may be over before there is a line again.
void SerialLink::watch_kept() {
  if (kept_->packet.expires == SteadyTime::max()) return;
  kept_expiry_ = scheduler_.at(kept_->packet.expires, [this] { drop_kept(); });
}

void SerialLink::drop_kept() {
  kept_expiry_.cancel();
  ++counters_.unacknowledged;
  queue_.report(std::move(kept_->packet.done), SendResult::kNotAcknowledged);
  kept_.reset();
}

// What comes.

void SerialLink::take(ByteView bytes) {
  while (up_) {
    const auto frame = reader_.next(bytes);
    if (!frame) return void(note_faults());
    if (!take_frame(*frame)) return;
  }
}

/// False: this is gone. The ack goes before the packet is looked at (wsn.md 2, rule 4).
bool SerialLink::take_frame(const motes::HdlcFrame& frame) {
  unheard_ = 0;
  const auto self = lifetime_.watch();
  if (frame.protocol == motes::kHdlcAckedPacket) send_ack(frame.sequence);
  if (self.ended() || !first_sound()) return false;
  if (frame.protocol != motes::kHdlcAck) return notifier_.received(frame.packet);
  acknowledge(frame.sequence);
  return !self.ended();
}

void SerialLink::send_ack(std::uint8_t sequence) {
  if (calls_.unwritten() <= kMostUnwritten) return calls_.write(motes::hdlc_ack(sequence));
  ++counters_.unsent_acks;
  (void)notifier_.note("unsent-acks", "the line takes no bytes: acks to the sink are not sent");
}

bool SerialLink::first_sound() {
  if (std::exchange(heard_, true)) return true;
  const auto self = lifetime_.watch();
  calls_.heard();
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

/// An ack of another packet's attempt is waited over (wsn.md 2). One of an earlier attempt of this packet shows that
/// the sink has it; but the last attempt is on its way to the sink too, and what follows too soon may be lost
/// (wsn.md 9.7).
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
    ack_.cancel();
  }
  const auto self = lifetime_.watch();
  calls_.acknowledges(true);
  if (!self.ended()) pump();
}

// What goes.

void SerialLink::pump() {
  if (!up_ || flight_) return;
  if (kept_ && kept_->packet.expires <= scheduler_.now()) drop_kept();
  if (kept_) {
    kept_expiry_.cancel();
    return start(*std::exchange(kept_, std::nullopt));
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
  const bool leaves_first = !flight_->again;
  attempt();
  if (leaves_first) notifier_.left(Bytes(flight_->packet.packet));  // whoever is told may end the flight
}

void SerialLink::attempt() {
  ++flight_->attempts;
  flight_->blocked = 0;
  calls_.write(motes::hdlc_acked_packet(sequence_++, flight_->packet.packet));
  ack_ = scheduler_.after(options_.ack_timeout, [this] { waited(); });
}

bool SerialLink::may_repeat() const {
  const auto& packet = flight_->packet;
  return packet.repeatable && flight_->attempts < options_.attempts && packet.expires > scheduler_.now();
}

/// No ack came in time. What the line has not even taken is not written once more.
void SerialLink::waited() {
  if (flight_->acknowledged) return next();
  if (calls_.unwritten() > 0) {
    if (++flight_->blocked >= options_.attempts)
      return calls_.failed({ErrorCode::kUnreachable, "the line takes no bytes"});
    ack_ = scheduler_.after(options_.ack_timeout, [this] { waited(); });
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
    const bool something = reader_.faults() != before_;
    return calls_.failed({ErrorCode::kUnreachable,
                          fmt::format("the sink does not acknowledge: no answer to {} attempts{}", attempts,
                                      something ? ", only bytes that are no frames: is the baud rate right?" : "")});
  }
  queue_.report(std::move(flight_->packet.done), SendResult::kNotAcknowledged);
  const auto self = lifetime_.watch();
  if (!notifier_.note("unacknowledged", fmt::format("no ack of a packet in {} attempts", attempts))) return;
  if (heard_ && ++unheard_ >= kMostUnheard) {
    flight_.reset();
    return calls_.failed({ErrorCode::kUnreachable, "the sink says nothing any more"});
  }
  calls_.acknowledges(false);
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
