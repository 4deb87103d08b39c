#include "networks/wsn/outgoing.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "networks/wsn/mote_messages.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::wsn {

namespace {

/// The programs of the motes use it for "no room" (wsn.md 5).
constexpr std::uint16_t kNoSequence = 0xffff;
/// Until the next try to send a repetition for which the lane was full.
constexpr Duration kBusyPause = std::chrono::milliseconds(200);

}  // namespace

MoteRequests::MoteRequests(Scheduler& scheduler, SendCall send, std::function<void()> unanswered)
    : scheduler_(scheduler),
      send_(std::move(send)),
      unanswered_attempt_(std::move(unanswered)),
      rng_(static_cast<std::uint_fast32_t>(scheduler.wall_now().time_since_epoch().count())) {}

std::uint16_t MoteRequests::free_sequence(std::uint16_t mote) {
  for (;;) {
    const auto sequence = static_cast<std::uint16_t>(rng_());
    if (sequence != kNoSequence && !pending_.contains({mote, sequence})) return sequence;
  }
}

Result<void> MoteRequests::send(MoteRequest request) {
  RUBICON_ASSERT(request.record.size() <= kMaxRecord);
  if (pending_.size() >= kMaxPending)
    return fail(ErrorCode::kBusy, fmt::format("{} messages to motes are pending", pending_.size()));
  const auto mote = request.header.destination_mote;
  const Key key{mote, request.sequence ? *request.sequence : free_sequence(mote)};
  if (pending_.contains(key))
    return fail(ErrorCode::kDuplicate,
                fmt::format("a message with sequence number {} to mote {} is pending", key.second, mote));
  const auto subject = request.subject;
  Pending& pending = pending_[key];
  pending.expires = scheduler_.now() + request.time_to_live;
  pending.request = std::move(request);
  auto transmitted = transmit(key, pending);
  if (!transmitted) pending_.erase(key);
  if (transmitted && subject) supersede(key, *subject);
  return transmitted;
}

void MoteRequests::supersede(const Key& by, std::uint16_t subject) {
  std::vector<Key> older;
  for (auto one = pending_.lower_bound({by.first, 0}); one != pending_.end() && one->first.first == by.first; ++one) {
    if (one->first != by && one->second.request.subject == subject) older.push_back(one->first);
  }
  for (const Key& key : older) {
    lifetime_.post(scheduler_, [this, key, attempt = pending_.at(key).attempt] {
      const auto found = pending_.find(key);
      if (found != pending_.end() && found->second.attempt == attempt) end(key, DeliveryResult::kSuperseded);
    });
  }
}

Result<void> MoteRequests::transmit(const Key& key, Pending& pending) {
  auto& request = pending.request;
  auto message = request.header;
  message.sequence = key.second;
  message.record = request.record;
  const bool repeatable = request.attempts > 1 || request.idempotent;
  sink::Outgoing out{motes::packet_of(message), request.lane, pending.expires, repeatable, {}};
  out.done =
      lifetime_.guard([this, key, attempt = ++last_attempt_](sink::SendResult result) { sent(key, attempt, result); });
  pending.attempt = last_attempt_;
  auto queued = send_(std::move(out));
  if (queued) ++pending.tries;
  return queued;
}

void MoteRequests::sent(const Key& key, std::uint64_t attempt, sink::SendResult result) {
  using sink::SendResult;
  const auto found = pending_.find(key);
  if (found == pending_.end() || found->second.attempt != attempt) return;  // the mote answered before
  auto& pending = found->second;
  if (result == SendResult::kRefused) return end(key, DeliveryResult::kRefused);
  if (result == SendResult::kExpired)
    return end(key, pending.reached_sink ? DeliveryResult::kNoAnswer : DeliveryResult::kExpired);
  const bool acknowledged = result == SendResult::kAcknowledged;
  if (!acknowledged && pending.request.attempts == 1) return end(key, DeliveryResult::kSinkSilent);
  pending.reached_sink = pending.reached_sink || acknowledged;
  if (pending.request.header.reliable == 0)
    return end(key, acknowledged ? DeliveryResult::kAcknowledged : DeliveryResult::kSinkSilent);
  pending.timeout = scheduler_.after(kAckTimeout, [this, key] { retry(key); });
}

void MoteRequests::retry(Key key) {
  auto& pending = pending_.at(key);
  if (pending.reached_sink && unanswered_attempt_) unanswered_attempt_();
  const bool over = pending.tries >= pending.request.attempts || scheduler_.now() >= pending.expires;
  if (over) return end(key, pending.reached_sink ? DeliveryResult::kNoAnswer : DeliveryResult::kSinkSilent);
  if (transmit(key, pending)) return;
  pending.timeout = scheduler_.after(kBusyPause, [this, key] { retry(key); });
}

bool MoteRequests::acknowledged(const motes::HeardAck& ack) {
  const Key key{ack.mote, ack.ack.sequence};
  const auto found = pending_.find(key);
  if (found == pending_.end() || found->second.request.header.reliable == 0) return false;
  end(key, ack.ack.status == 0 ? DeliveryResult::kAcknowledged : DeliveryResult::kRejected);
  return true;
}

void MoteRequests::end(Key key, DeliveryResult result) {
  auto ended = pending_.extract(key);
  if (result == DeliveryResult::kNoAnswer) ++unanswered_;
  if (auto done = std::move(ended.mapped().request.done)) done(result);
}

namespace {

/// Actuator ids (wsn.md 6).
constexpr std::uint16_t kLed = 1, kRelay = 2;
/// A record type that no program of the motes reads (wsn.md 9.3).
constexpr std::uint8_t kNoCommand = 0;

motes::NetMessage header(std::uint16_t island, std::uint16_t mote, bool reliable, std::uint8_t transport,
                         std::uint8_t application) {
  motes::NetMessage message;
  message.destination_island = message.source_island = island;
  message.destination_mote = mote;
  message.source_mote = motes::kBaseMote;
  message.reliable = reliable ? 1 : 0;
  message.transport = transport;
  message.application = application;
  return message;
}

Result<std::int32_t> count_of(const model::Value& value) {
  std::optional<double> number;
  if (const auto* on = std::get_if<bool>(&value)) number = *on ? 1 : 0;
  if (const auto* whole = std::get_if<std::int64_t>(&value)) number = static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(&value)) number = *real;
  using Limits = std::numeric_limits<std::int32_t>;
  if (number && std::nearbyint(*number) == *number && *number >= Limits::min() && *number <= Limits::max())
    return static_cast<std::int32_t>(*number);
  return fail(ErrorCode::kOutOfRange, fmt::format("{}: expected a whole number of 32 bits", model::to_text(value)));
}

/// True also for a record that is cut short: a mote reads on in its memory.
bool sets_actuator(const motes::NetMessage& message) {
  static const auto kType = motes::encode_record(motes::ActuateCommand{}).front();
  return message.transport == motes::kTransportConnectionless && message.application == motes::kApplicationMockup &&
         !message.record.empty() && message.record.front() == kType;
}

Error actuator_in_message() {
  return {ErrorCode::kRefused, "messages cannot command actuators: set the actuator's .command instead"};
}

}  // namespace

Result<MoteRequest> actuate_request(std::uint16_t island, std::uint16_t mote, std::string_view actuator_type,
                                    const model::Actuate& command) {
  const std::uint16_t actuator = actuator_type == "led" ? kLed : actuator_type == "relay" ? kRelay : 0;
  if (actuator == 0 || command.point.instance != "1")
    return fail(ErrorCode::kNotFound, fmt::format("motes have no actuator {}-{}, expected led-1 or relay-1",
                                                  model::quoted(actuator_type), model::quoted(command.point.instance)));
  const auto value = count_of(command.value);
  if (!value) return fail(value.error());
  MoteRequest request;
  request.header = header(island, mote, true, motes::kTransportConnectionless, motes::kApplicationMockup);
  request.record = motes::encode_record(motes::ActuateCommand{actuator, *value});
  request.subject = actuator;
  if (command.time_to_live.count() > 0) request.time_to_live = command.time_to_live;
  return request;
}

MoteRequest probe_request(std::uint16_t island, std::uint16_t mote) {
  MoteRequest request;
  request.header = header(island, mote, true, motes::kTransportConnectionless, motes::kApplicationMockup);
  request.record = {kNoCommand};
  request.lane = sink::Lane::kProbe;
  request.attempts = 1;
  request.idempotent = true;
  request.time_to_live = std::chrono::minutes(1);
  return request;
}

MoteRequest ack_request(std::uint16_t island, const motes::WantedAck& wanted) {
  MoteRequest request;
  request.header = header(island, wanted.mote, false, motes::kTransportAck, wanted.application);
  request.record = motes::encode_record(motes::MoteAck{wanted.sequence, 0});
  request.lane = sink::Lane::kSampling;  // not kCommand: many acknowledgements must not delay commands
  return request;
}

Result<MoteRequest> opaque_request(std::uint16_t island, std::uint16_t mote, const model::Message& message,
                                   const MoteTag& tag) {
  const auto& opaque = std::get<model::Opaque>(message.body);
  MoteRequest request;
  request.attempts = 1;
  if (tag.reliable && mote == motes::kBroadcast)
    return fail(ErrorCode::kUnsupported, "a message to all motes cannot be acknowledged: send it without /reliable");
  if (tag.kind == MoteTag::Kind::kJson) {
    auto learning = learning_message(base::as_text(opaque.bytes));
    if (!learning) return fail(learning.error());
    request.header = header(island, mote, tag.reliable, learning->transport, learning->application);
    request.record = std::move(learning->record);
  } else {
    if (opaque.bytes.empty() || opaque.bytes.front() != tag.type)
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: expected a record that begins with {:02x}", opaque.type, tag.type));
    request.header = header(island, mote, tag.reliable, tag.transport, tag.application);
    request.record = opaque.bytes;
    request.sequence = tag.sequence;
  }
  if (request.record.size() > kMaxRecord)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("a record of {} bytes, expected at most {}", request.record.size(), kMaxRecord));
  auto whole = request.header;
  whole.record = request.record;
  if (sets_actuator(whole)) return fail(actuator_in_message());
  const auto from = model::number(message.source.island);
  if (from == 0 || from == island || from >= motes::kBaseMote) return request;
  request.header.source_island = static_cast<std::uint16_t>(from);
  request.header.source_mote = mote_address(message.source.device).value_or(motes::kBaseMote);
  return request;
}

Result<Bytes> am_packet(const model::Message& message, const MoteTag& tag) {
  const auto& bytes = std::get<model::Opaque>(message.body).bytes;
  if (tag.type == static_cast<std::uint8_t>(motes::AmType::kConfig))
    return fail(ErrorCode::kRefused, "messages cannot configure the sink: the island sets its id");
  if (!message.destination.device.empty())
    return fail(ErrorCode::kNotFound, "packets of an AM type go to the sink: address the network, not a device");
  if (bytes.size() > motes::kMaxPayload)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("a payload of {} bytes, expected at most {}", bytes.size(), motes::kMaxPayload));
  if (tag.type == static_cast<std::uint8_t>(motes::AmType::kNetMessage)) {
    if (const auto carried = motes::decode_net(bytes); carried && sets_actuator(*carried))
      return fail(actuator_in_message());
  }
  return motes::packet_of(static_cast<motes::AmType>(tag.type), bytes);
}

std::optional<model::Message> acknowledgement_for_applications(const motes::HeardAck& ack) {
  if (ack.application == motes::kApplicationMockup || ack.application == motes::kApplicationControl)
    return std::nullopt;
  auto record = motes::encode_record(ack.ack);
  model::Message message;
  message.source.device = fmt::format("{}", ack.mote);
  message.body =
      model::Opaque{fmt::format("mote/{}/{}/{}", motes::kTransportAck, ack.application, record.front()), record};
  return message;
}

std::optional<model::Opaque> as_json(const model::Opaque& message) {
  const auto tag = parse_tag(message.type);
  if (!tag || tag->kind != MoteTag::Kind::kNet) return std::nullopt;
  motes::NetMessage net;
  net.destination_mote = motes::kBaseMote;
  net.transport = tag->transport;
  net.application = tag->application;
  net.record = message.bytes;
  const auto json = learning_json(net);
  if (!json) return std::nullopt;
  const auto bytes = base::as_bytes(*json);
  return model::Opaque{"mote/json", Bytes(bytes.begin(), bytes.end())};
}

bool may_repeat(const motes::DecodedPacket& packet) {
  if (packet.radio) return !std::holds_alternative<motes::OtherRecord>(packet.radio->record);
  return packet.packet.is(motes::AmType::kConfig);
}

std::optional<ReadOrder> read_order_in(const motes::RadioMessage& message) {
  const auto mote = message.header.destination_mote;
  if (const auto* periodic = std::get_if<motes::PeriodicCommand>(&message.record))
    return ReadOrder{mote, periodic->transducers};
  if (std::holds_alternative<motes::ReadUpdates>(message.record)) return ReadOrder{mote, std::nullopt};
  return std::nullopt;
}

std::optional<ReadOrder> read_order_in(const MoteRequest& request) {
  auto header = request.header;
  header.record = request.record;
  auto record = motes::decode_record(header);
  if (!record) return std::nullopt;
  return read_order_in(motes::RadioMessage{header, std::move(*record)});
}

DeliveryResult delivery_result_of(sink::SendResult result) {
  switch (result) {
    case sink::SendResult::kAcknowledged: return DeliveryResult::kAcknowledged;
    case sink::SendResult::kExpired: return DeliveryResult::kExpired;
    case sink::SendResult::kRefused: return DeliveryResult::kRefused;
    case sink::SendResult::kNotAcknowledged: break;
  }
  return DeliveryResult::kSinkSilent;
}

model::Acknowledge acknowledge_of(std::uint64_t number, DeliveryResult result, std::uint16_t mote) {
  using model::Outcome;
  const auto outcome = [number](Outcome kind, std::string text = {}) {
    return model::Acknowledge{number, kind, std::move(text)};
  };
  switch (result) {
    case DeliveryResult::kAcknowledged: return outcome(Outcome::kSent);
    case DeliveryResult::kNoAnswer:
      return outcome(Outcome::kFailed,
                     fmt::format("mote {} did not acknowledge it: whether it was executed is unknown", mote));
    case DeliveryResult::kSinkSilent: return outcome(Outcome::kUndeliverable, "the sink did not acknowledge it");
    case DeliveryResult::kExpired:
      return outcome(Outcome::kUndeliverable, "expired: the sink was busy or away for too long");
    case DeliveryResult::kRefused: return outcome(Outcome::kRefused, "the motes of a recording take no messages");
    case DeliveryResult::kRejected:
      return outcome(Outcome::kFailed, fmt::format("mote {} acknowledged it with an error", mote));
    case DeliveryResult::kSuperseded:
      return outcome(Outcome::kFailed, "a newer command came before the mote acknowledged it");
  }
  return outcome(Outcome::kUndeliverable);
}

}  // namespace rubicon::networks::wsn
