#include "apps/simulators/motes/sink_firmware.h"

#include <algorithm>
#include <utility>

#include "motes/mote_records.h"

namespace rubicon::motes_simulator {

namespace {

using namespace std::chrono_literals;
using motes::AmType;
using motes::kBaseMote;
using motes::kBroadcast;
using motes::kSinkMote;
using motes::NetMessage;

constexpr Duration kMaxProcessing = 40ms;
constexpr Duration kAfterAck = 1ms;
/// True length of an acknowledgement; the sink writes it in its own ones only (wsn.md 5).
constexpr std::uint8_t kAckCount = 6;
constexpr std::size_t kJoinRequest = 6;
constexpr std::size_t kJoinAckSize = 14;
constexpr std::uint8_t kSerialJoined = 0x10;

}  // namespace

SinkFirmware::SinkFirmware(SinkOptions options, Radio& radio, Scheduler& scheduler, const EventLog& log)
    : options_(options),
      scheduler_(scheduler),
      log_(log),
      transmitter_(radio, scheduler),
      node_(radio.add(*this, {options.number})),
      output_(options.baud, scheduler),
      sensors_(options.seed),
      memory_(options.stale, options.seed),
      mockup_({}, sensors_, transmitter_.random(), scheduler,
              {[this](Peer to, std::uint8_t application, ByteView record) { send_own(to, application, record); },
               [](std::uint16_t, std::int32_t) {}}),
      rng_(options.seed),
      island_(options.island) {
  transmitter_.start(node_, kSinkMote);
}

void SinkFirmware::kill() {
  const bool congested_before = congested();
  on_ = false;
  transmitter_.stop();
  output_.reset();
  receiver_.reset();
  mockup_.reset();
  memory_.clear();
  joining_.reset();
  frame_length_ = 0;
  line_free_ = processor_free_ = executed_ = {};
  arriving_.clear();
  acks_.clear();
  processing_.clear();
  ready_.clear();
  for (auto* timer : {&line_timer_, &arrival_timer_, &ack_timer_, &processing_timer_, &execution_timer_})
    timer->cancel();
  if (congested_before) notify_room();
}

void SinkFirmware::reboot() {
  kill();
  on_ = true;
  island_ = options_.island;
  sensors_.restart();
  transmitter_.start(node_, kSinkMote);
  log_event("sink-boot");
}

void SinkFirmware::log_event(std::string_view what, std::uint16_t mote, const NetMessage* message) const {
  if (!log_) return;
  Event event{{}, what, options_.number, mote, std::nullopt, std::nullopt, {}};
  if (message != nullptr) {
    event.sequence = message->sequence;
    const std::size_t length = message->counted > 2 ? message->counted - 2U : 1U;
    const auto record = message->record.first(std::min(length, message->record.size()));
    event.record.assign(record.begin(), record.end());
  }
  log_(std::move(event));
}

// --- From the serial line.

void SinkFirmware::received(ByteView bytes) {
  if (!on_) return;
  line_free_ = std::max(line_free_, scheduler_.now());
  for (const auto byte : bytes) {
    line_free_ += SerialOutput::line_time(1, options_.baud);
    ++frame_length_;
    auto frame = receiver_.take(byte);
    if (!frame) continue;
    const auto length = std::exchange(frame_length_, 0);
    if (arriving_.size() < kMaxBacklog) arriving_.push_back({std::move(*frame), line_free_, length, {}, {}});
  }
  await_frames();
  await_line();
}

void SinkFirmware::disconnected() {
  const auto now = scheduler_.now();
  line_free_ = std::min(line_free_, now);
  std::erase_if(arriving_, [now](const Arriving& one) { return one.at > now; });
  arrival_timer_.cancel();
  line_timer_.cancel();
  await_frames();
}

/// Invalid bytes never complete a frame, so the free space is computed from the baud rate.
void SinkFirmware::await_line() {
  if (line_timer_.pending() || line_free_ <= scheduler_.now() + kLineAhead) return;
  line_timer_ = scheduler_.at(line_free_ - kLineAhead, [this] {
    await_line();
    notify_room();
  });
}

void SinkFirmware::notify_room() {
  if (!congested() && room_) room_();
}

void SinkFirmware::await_frames() {
  if (arrival_timer_.pending() || arriving_.empty()) return;
  arrival_timer_ = scheduler_.at(arriving_.front().at, [this] { arrived(); });
}

void SinkFirmware::arrived() {
  const bool congested_before = congested();
  auto one = std::move(arriving_.front());
  arriving_.pop_front();
  await_frames();
  take(std::move(one));
  if (congested_before) notify_room();
}

/// Every valid frame is acknowledged; one that finds both buffers occupied is not executed (wsn.md 9.7, 10).
void SinkFirmware::take(Arriving arrived) {
  const auto frame_time = SerialOutput::line_time(std::min<std::size_t>(arrived.length, 300), options_.baud);
  const auto processing =
      std::min(std::chrono::duration_cast<Duration>(frame_time * options_.processing), kMaxProcessing);
  if (arrived.frame.protocol == motes::kHdlcAckedPacket)
    arrived.acknowledged = acknowledge(arrived.frame.sequence, processing);
  if (watch_) watch_(true, arrived.frame.packet);
  if (processing_.size() >= kSerialIn) return log_event("overrun");
  processor_free_ = std::max(processor_free_, scheduler_.now()) + processing;
  arrived.at = processor_free_;
  arrived.processing = processing;
  processing_.push_back(std::move(arrived));
  await_processing();
}

SteadyTime SinkFirmware::acknowledge(std::uint8_t sequence, Duration processing) {
  const auto& ack = options_.ack;
  auto delay = ack.shortest;
  if (ack.longest > ack.shortest) {
    const auto share = std::uniform_real_distribution<>(0, 1)(rng_);
    delay += std::chrono::duration_cast<Duration>((ack.longest - ack.shortest) * share);
    if (std::uniform_real_distribution<>(0, 1)(rng_) < ack.outlier_share) delay = ack.outlier;
  }
  auto at = scheduler_.now() + std::max(delay, processing);
  if (!acks_.empty()) at = std::max(at, acks_.back().at);
  if (acks_.size() >= SerialOutput::kAcks) return at;
  acks_.push_back({at, sequence});
  await_acks();
  return at;
}

void SinkFirmware::await_acks() {
  if (ack_timer_.pending() || acks_.empty()) return;
  ack_timer_ = scheduler_.at(acks_.front().at, [this] {
    const auto ack = acks_.front();
    acks_.pop_front();
    await_acks();
    output_.ack(ack.sequence);
  });
}

void SinkFirmware::await_processing() {
  if (processing_timer_.pending() || processing_.empty()) return;
  processing_timer_ = scheduler_.at(processing_.front().at, [this] { processed(); });
}

void SinkFirmware::processed() {
  auto one = std::move(processing_.front());
  processing_.pop_front();
  await_processing();
  one.at = executed_ = std::max({one.at, one.acknowledged + kAfterAck, executed_ + one.processing});
  ready_.push_back(std::move(one));
  await_execution();
}

void SinkFirmware::await_execution() {
  if (execution_timer_.pending() || ready_.empty()) return;
  execution_timer_ = scheduler_.at(ready_.front().at, [this] {
    const auto one = std::move(ready_.front());
    ready_.pop_front();
    await_execution();
    execute(one.frame.packet);
  });
}

// --- From the computer.

/// The sink ignores destination, source, group and length of the AM header (wsn.md 10).
void SinkFirmware::execute(const Bytes& packet) {
  const auto read = motes::decode_packet(packet);
  if (!read || read->payload.size() > kAirPayload) return;
  if (read->is(AmType::kConfig)) return on_config(read->payload);
  if (read->is(AmType::kNetMessage)) on_serial_message(read->payload);
}

void SinkFirmware::on_config(ByteView payload) {
  const auto config = motes::decode_config(payload);
  if (!config || config->command != motes::kSetIslandId) return;
  island_ = config->value;
  if (log_) log_({{}, "island", options_.number, 0, std::nullopt, island_, {}});
}

void SinkFirmware::on_serial_message(ByteView payload) {
  if (payload.size() < kNetHeader) return;
  Bytes whole(payload.begin(), payload.end());
  whole.resize(kAirPayload);
  const auto message = motes::decode_net(whole);
  if (!message || message->destination_mote == kBaseMote) return;
  const auto mote = message->destination_mote;
  if (mote != kSinkMote) forward(mote, whole, message->counted);
  if (mote == kSinkMote || mote == kBroadcast) on_own_message(*message);
}

/// The length on the radio is that of the message's own field (wsn.md 8).
void SinkFirmware::forward(std::uint16_t mote, ByteView payload, std::uint8_t counted) {
  const auto length = std::min(payload.size(), kNetHeader + counted);
  const auto sent = payload.first(length);
  if (!transmitter_.send({kAirNetMessage, mote, kSinkMote, Bytes(sent.begin(), sent.end())}))
    log_event("radio-full", mote);
}

void SinkFirmware::on_own_message(const NetMessage& message) {
  if (message.transport != motes::kTransportConnectionless) return;
  if (message.reliable != 0) acknowledge_message(message);
  // The recordings show no report of a sink although it got periodic commands.
  const bool executed = options_.readings && mockup_.take(message);
  log_event(executed ? "executed" : "ignored", kSinkMote, &message);
}

void SinkFirmware::acknowledge_message(const NetMessage& message) {
  base::ByteWriter record;
  record.u8(0x17).u16_be(message.sequence).u8(0);
  NetMessage ack{message.source_island, message.source_mote, island_,      kSinkMote, 0, 0, kAckCount,
                 motes::kTransportAck,  message.application, record.view()};
  ack.sequence = transmitter_.random().next();
  route_own({message.source_island, message.source_mote}, memory_.build_ack(ack));
}

void SinkFirmware::send_own(Peer to, std::uint8_t application, ByteView record) {
  const NetMessage message{to.island,   to.mote,
                           island_,     kSinkMote,
                           0,           transmitter_.random().next(),
                           kFullCount,  motes::kTransportConnectionless,
                           application, record};
  route_own(to, memory_.build(message));
}

/// Its messages to the computer of another island are lost (wsn.md 9.8).
void SinkFirmware::route_own(Peer to, Bytes payload) {
  if (to.mote != kBaseMote) return forward(to.mote, payload, kFullCount);
  if (to.island == island_) to_serial(payload);
}

// --- From the radio.

bool SinkFirmware::hear(const AirMessage& message) {
  if (!on_ || (message.destination != kSinkMote && message.destination != kBroadcast)) return false;
  if (message.type == kAirJoinRequest) on_join_request(message);
  if (message.type == kAirAckJoin) on_ack_join(message.payload);
  if (message.type == kAirNetMessage) on_air_message(message.payload);
  return true;
}

/// Answers every request, also of motes that have joined, with the address that the mote has (wsn.md 9.2).
void SinkFirmware::on_join_request(const AirMessage& request) {
  if (request.payload.size() < kJoinRequest) return;
  base::ByteReader reader(request.payload);
  joining_ = Joining{request.source, reader.u16_be()};
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(scheduler_.now().time_since_epoch());
  base::ByteWriter reply;
  reply.u16_be(island_).u16_be(request.source).u32_be(static_cast<std::uint32_t>(milliseconds.count()));
  reply.u16_be(joining_->sequence);
  const auto to = options_.reply_to_all ? kBroadcast : request.source;
  transmitter_.send({kAirJoinReply, to, kSinkMote, reply.take()});
}

void SinkFirmware::on_ack_join(ByteView payload) {
  if (payload.size() != kJoinAckSize || !joining_) return;
  base::ByteReader reader(payload);
  const auto island = reader.u16_be();
  const auto sink = reader.u16_be();
  reader.skip(2);
  const auto mote = reader.u16_be();
  const auto sequence = reader.u16_be();
  if (island != island_ || sink != kSinkMote || mote != joining_->mote || sequence != joining_->sequence) return;
  joining_.reset();
  base::ByteWriter record;
  record.u8(kSerialJoined).u16_be(island_).u16_be(mote).bytes(reader.take(4));
  log_event("listed", mote);
  to_serial(memory_.build({island_, kBaseMote, island_, mote, 0, 0, kFullCount, motes::kTransportConnectionless,
                           motes::kApplicationControl, record.view()}));
}

/// Forwards messages for the computer of its own island, and those of its own motes to other islands (wsn.md 9.8).
void SinkFirmware::on_air_message(ByteView payload) {
  Bytes whole(payload.begin(), payload.end());
  if (whole.size() < kNetHeader) return;
  whole.resize(kAirPayload);
  const auto message = motes::decode_net(whole);
  if (!message) return;
  const bool own = message->destination_island == island_;
  if (own && message->destination_mote != kBaseMote) return on_own_message(*message);
  if (own || message->source_island == island_) to_serial(whole);
}

void SinkFirmware::to_serial(ByteView payload) {
  const motes::AmHeader header{kBroadcast, 0, static_cast<std::uint8_t>(kAirPayload), 0,
                               static_cast<std::uint8_t>(AmType::kNetMessage)};
  const auto packet = motes::encode_packet({header, payload});
  if (!output_.packet(packet)) return log_event("serial-full");
  if (watch_) watch_(false, packet);
}

}  // namespace rubicon::motes_simulator
