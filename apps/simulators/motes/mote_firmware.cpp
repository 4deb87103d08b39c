#include "apps/simulators/motes/mote_firmware.h"

#include <utility>

#include "base/assert.h"
#include "base/text.h"
#include "motes/mote_records.h"

namespace rubicon::motes_simulator {

namespace {

using motes::kBaseMote;
using motes::kBroadcast;
using motes::kSinkMote;
using motes::kTransportAck;
using motes::kTransportConnectionless;
using motes::NetMessage;

constexpr std::uint32_t kJoinPause = 500;  ///< TinyOS milliseconds: 488 ms
constexpr std::size_t kJoinReply = 10;
constexpr std::size_t kAckJoin = 14;

}  // namespace

std::optional<BoardBuild> parse_build(std::string_view name) {
  if (name == "STANDARD") return BoardBuild{0x6f52, 0x1f43};
  if (name == "EM1000") return BoardBuild{0x1f4f, 0x1f4f};
  if (name == "SE1000") return BoardBuild{0x00b0, 0x00b0};
  const auto mask = base::parse_hex_number<std::uint16_t>(name);
  if (name.size() != 4 || !mask) return std::nullopt;
  return BoardBuild{*mask, *mask};
}

MoteFirmware::MoteFirmware(MoteOptions options, Radio::Cells hears, Radio& radio, Scheduler& scheduler,
                           const EventLog& log)
    : options_(options),
      radio_(radio),
      scheduler_(scheduler),
      log_(log),
      node_(radio.add(*this, std::move(hears))),
      transmitter_(radio, scheduler),
      sensors_(options.seed),
      memory_(options.stale, options.seed),
      mockup_({options.board.real, options.sensor_time, options.obey, options.updates}, sensors_, transmitter_.random(),
              scheduler,
              {[this](Peer to, std::uint8_t application, ByteView record) { send(to, application, record); },
               [this](std::uint16_t, std::int32_t value) {
                 if (log_) log_({{}, "actuator", 0, options_.address, std::nullopt, value, {}});
               }}) {
  RUBICON_ASSERT(options.address > kSinkMote && options.address < kBaseMote);
}

void MoteFirmware::log_event(std::string_view what, const NetMessage* message) const {
  if (!log_) return;
  const auto& cells = radio_.cells(node_);
  Event event{{},           what, cells.empty() ? std::uint16_t{0} : cells.front(), options_.address, std::nullopt,
              std::nullopt, {}};
  if (message != nullptr) {
    event.sequence = message->sequence;
    event.record.assign(message->record.begin(), message->record.end());
  }
  log_(std::move(event));
}

void MoteFirmware::boot() {
  kill();
  on_ = true;
  transmitter_.start(node_, options_.address);
  memory_.clear();
  sensors_.restart();
  requests_ = 0;
  log_event("boot");
  request_join();
}

void MoteFirmware::kill() {
  if (on_) log_event("off");
  ++boot_count_;
  on_ = joined_ = false;
  island_ = 0;
  join_timer_.cancel();
  mockup_.reset();
  transmitter_.stop();
}

void MoteFirmware::request_join() {
  if (joined_ || requests_ == kJoinRequests) return;
  ++requests_;
  replied_ = false;
  join_sequence_ = transmitter_.random().next();
  base::ByteWriter request;
  request.u16_be(join_sequence_).u8(options_.type).u16_be(options_.board.declared).u8(options_.actuators);
  transmitter_.send({kAirJoinRequest, kSinkMote, options_.address, request.take()});
  join_timer_ = scheduler_.after(tinyos_ms(kJoinPause), [this] { request_join(); });
}

bool MoteFirmware::hear(const AirMessage& message) {
  if (!on_ || (message.destination != options_.address && message.destination != kBroadcast)) return false;
  if (message.type == kAirJoinReply) on_join_reply(message.payload);
  if (message.type == kAirNetMessage) on_net(message.payload);
  return true;
}

/// Known bug of the firmware: it answers replies to other motes too, with memory garbage (wsn.md 9.2).
void MoteFirmware::on_join_reply(ByteView payload) {
  if (joined_ || replied_ || payload.size() != kJoinReply) return;
  base::ByteReader reader(payload);
  const auto island = reader.u16_be();
  reader.skip(6);
  const auto sequence = reader.u16_be();
  if (sequence == join_sequence_) {
    island_ = island;
    replied_ = true;  // the first reply wins (wsn.md 9.9)
    return acknowledge_join(sequence);
  }
  Bytes garbage(kAckJoin);
  for (auto& byte : garbage) byte = static_cast<std::uint8_t>(memory_.rng()() & 0xffU);
  transmitter_.send({kAirAckJoin, kSinkMote, options_.address, std::move(garbage)});
}

void MoteFirmware::acknowledge_join(std::uint16_t sequence) {
  base::ByteWriter ack;
  ack.u16_be(island_).u16_be(kSinkMote).u16_be(island_).u16_be(options_.address).u16_be(sequence);
  ack.u8(options_.type).u16_be(options_.board.declared).u8(options_.actuators);
  transmitter_.send({kAirAckJoin, kSinkMote, options_.address, ack.take()},
                    [this, boot = boot_count_](bool acknowledged) {
                      if (!acknowledged || joined_ || boot != boot_count_) return;
                      joined_ = true;
                      join_timer_.cancel();
                      log_event("joined");
                    });
}

void MoteFirmware::on_net(ByteView payload) {
  const auto message = motes::decode_net(payload);
  if (!message || !joined_ || message->destination_island != island_) return;
  if (message->destination_mote == options_.address || message->destination_mote == kBroadcast) on_message(*message);
}

void MoteFirmware::on_message(const NetMessage& message) {
  if (message.transport != kTransportConnectionless) return;
  if (message.reliable != 0) acknowledge(message);
  log_event(mockup_.take(message) ? "executed" : "ignored", &message);
}

void MoteFirmware::acknowledge(const NetMessage& message) {
  base::ByteWriter record;
  record.u8(0x17).u16_be(message.sequence).u8(0);
  NetMessage ack{message.source_island, message.source_mote, island_,      options_.address, 0, 0, kFullCount,
                 kTransportAck,         message.application, record.view()};
  ack.sequence = transmitter_.random().next();
  transmit({message.source_island, message.source_mote}, memory_.build_ack(ack));
}

void MoteFirmware::send(Peer to, std::uint8_t application, ByteView record) {
  NetMessage message{to.island,   to.mote,
                     island_,     options_.address,
                     0,           transmitter_.random().next(),
                     kFullCount,  kTransportConnectionless,
                     application, record};
  transmit(to, memory_.build(message));
}

/// One hop. Messages for another island go to the sink as well, which handles them (wsn.md 9.8).
void MoteFirmware::transmit(Peer to, Bytes payload) {
  const auto next = to.mote == kBaseMote || to.island != island_ ? kSinkMote : to.mote;
  if (!transmitter_.send({kAirNetMessage, next, options_.address, std::move(payload)})) log_event("lost");
}

}  // namespace rubicon::motes_simulator
