#include "model/message.h"

#include <fmt/format.h>

#include <cmath>

#include "model/message_fields.h"
#include "model/type_names.h"

namespace rubicon::model {

std::string_view to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kSent: return "sent";
    case Outcome::kFailed: return "failed";
    case Outcome::kUnsupported: return "unsupported";
    case Outcome::kUndeliverable: return "undeliverable";
    case Outcome::kRefused: return "refused";
    case Outcome::kBusy: return "busy";
  }
  return "unknown";
}

std::string_view to_string(LineState state) {
  switch (state) {
    case LineState::kDown: return "down";
    case LineState::kConnecting: return "connecting";
    case LineState::kUp: return "up";
    case LineState::kEnded: return "ended";
    case LineState::kRefused: return "refused";
  }
  return "unknown";
}

std::string_view to_string(MessageKind kind) {
  switch (kind) {
    case MessageKind::kJoin: return "join";
    case MessageKind::kKeepAlive: return "keepalive";
    case MessageKind::kLeave: return "leave";
    case MessageKind::kUpdates: return "updates";
    case MessageKind::kActuate: return "actuate";
    case MessageKind::kSample: return "sample";
    case MessageKind::kSetProperty: return "set-property";
    case MessageKind::kAcknowledge: return "acknowledge";
    case MessageKind::kState: return "state";
    case MessageKind::kOpaque: return "opaque";
    case MessageKind::kProbe: return "probe";
    case MessageKind::kUnreachable: return "unreachable";
  }
  return "unknown";
}

using nlohmann::json;

namespace {

constexpr std::uint64_t kFormVersion = 1;
constexpr std::uint64_t kAny64 = UINT64_MAX;
constexpr std::uint64_t kMaxDeadlineTime = 3'200'000'000'000;  // ms; what a configuration may say, fits a Duration
constexpr std::uint64_t kMaxWordNumber = 65535;
constexpr std::size_t kMaxSenderText = 64;  ///< name, role

json address_out(const Address& address) {
  json out{{"island", number(address.island)}};
  if (!address.network.empty()) out["network"] = address.network;
  if (!address.device.empty()) out["device"] = address.device;
  return out;
}

Address address_in(FieldReader in) {
  return {OwnerId(static_cast<std::uint32_t>(in.number("island", UINT32_MAX))), in.text("network", 255),
          in.text("device", 255)};
}

/// Users and groups of this host (`group:staff`) mean nothing on another one.
json sender_out(const Sender& sender) {
  json out{{"name", sender.name}};
  for (const auto& role : sender.roles) {
    if (role.find(':') == role.npos) out["roles"].push_back(role);
  }
  if (sender.island != kNoOwner) out["island"] = number(sender.island);
  return out;
}

Sender sender_in(FieldReader in) {
  Sender sender{in.text("name", kMaxSenderText), in.names("roles", kMaxRoles, kMaxSenderText)};
  if (sender.name.empty()) in.wrong("name", "the name of a member");
  sender.island = OwnerId(static_cast<std::uint32_t>(in.number("island", UINT32_MAX)));
  return sender;
}

void point_out(const PointId& point, json& out) {
  out["kind"] = to_string(point.kind);
  out["type"] = static_cast<std::uint16_t>(point.type);
  if (!point.instance.empty()) out["instance"] = point.instance;
}

PointId point_in(FieldReader& in) {
  PointId point;
  const auto kind = in.text("kind");
  if (kind == "actuator") {
    point.kind = Kind::kActuator;
  } else if (kind == "property") {
    point.kind = Kind::kProperty;
  } else if (kind != "sensor") {
    in.wrong("kind", "sensor, actuator or property");
  }
  point.type = TypeId(static_cast<std::uint16_t>(in.number("type", UINT16_MAX)));
  point.instance = in.text("instance", 255);
  return current_point(std::move(point));
}

json capability_out(const Capability& capability) {
  json out;
  point_out(capability.point, out);
  if (!capability.type_name.empty()) out["name"] = capability.type_name;
  out["access"] = to_string(capability.access);
  if (!capability.unit.empty()) out["unit"] = capability.unit;
  // An infinite bound says no more than an absent one, and readers refuse it.
  if (capability.minimum && std::isfinite(*capability.minimum)) out["min"] = *capability.minimum;
  if (capability.maximum && std::isfinite(*capability.maximum)) out["max"] = *capability.maximum;
  for (const auto& word : capability.words) out["words"].push_back({{"value", word.value}, {"word", word.text}});
  if (capability.deadline) {
    out["deadline-ms"] = std::chrono::ceil<std::chrono::milliseconds>(*capability.deadline).count();
  }
  if (!capability.reports) out["reports"] = false;
  if (capability.sampled) out["sampled"] = true;
  if (capability.data) out["data"] = to_string(*capability.data);
  if (capability.report == Report::kEvent) out["report"] = "event";
  if (capability.initial.index() != 0) out["initial"] = value_to_json(capability.initial);
  return out;
}

template <class Enum>
Enum word_in(FieldReader& in, const char* key, Enum last) {
  const auto word = in.text(key);
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (to_string(static_cast<Enum>(i)) == word) return static_cast<Enum>(i);
  }
  in.wrong(key, "a known word");
  return Enum{};
}

std::vector<Word> words_in(FieldReader& in) {
  std::vector<Word> words;
  in.each("words", [&words](FieldReader& item) {
    words.push_back({static_cast<std::uint32_t>(item.number("value", kMaxWordNumber)), item.text("word", 255)});
    if (words.back().text.empty()) item.wrong("word", "a word");
  });
  return words;
}

Capability capability_in(FieldReader& in) {
  Capability capability;
  capability.point = point_in(in);
  capability.type_name = current_type(in.text("name", 255));
  const auto access = in.text("access");
  capability.access = access == "write" ? Access::kWrite : access == "read-write" ? Access::kReadWrite : Access::kRead;
  if (!access.empty() && access != to_string(capability.access)) in.wrong("access", "read, write or read-write");
  capability.unit = in.text("unit", 255);
  if (in.has("min")) capability.minimum = in.real("min");
  if (in.has("max")) capability.maximum = in.real("max");
  capability.words = words_in(in);
  if (in.has("deadline-ms")) {
    capability.deadline = std::chrono::milliseconds(in.number("deadline-ms", kMaxDeadlineTime));
  }
  if (in.has("reports")) capability.reports = in.boolean("reports");
  if (in.has("sampled")) capability.sampled = in.boolean("sampled");
  if (in.has("data")) capability.data = word_in(in, "data", DataType::kBytes);
  if (in.has("report")) {
    const auto report = in.text("report");
    capability.report = report == "event" ? Report::kEvent : Report::kState;
    if (report != "event" && report != "state") in.wrong("report", "state or event");
  }
  capability.initial = in.value("initial");
  return capability;
}

struct BodyWriter {
  json operator()(const Join& join) const {
    json out{{"heard", join.heard}, {"capabilities", json::array()}};
    if (!join.device_type.empty()) out["device-type"] = join.device_type;
    if (!join.name.empty()) out["name"] = join.name;
    if (!join.model.empty()) out["model"] = join.model;
    if (!join.id.empty()) out["id"] = join.id;
    if (!join.problem.empty()) out["problem"] = join.problem;
    if (!join.area.empty()) out["area"] = join.area;
    for (const auto& capability : join.capabilities) out["capabilities"].push_back(capability_out(capability));
    return out;
  }
  json operator()(const KeepAlive&) const { return json::object(); }
  json operator()(const Leave& leave) const { return {{"reason", leave.reason}}; }
  json operator()(const Updates& updates) const {
    json out{{"readings", json::array()}};
    if (!updates.heard) out["heard"] = false;
    for (const auto& reading : updates.readings) {
      json entry{{"value", value_to_json(reading.value)}};
      point_out(reading.point, entry);
      if (!reading.why.empty()) entry["why"] = reading.why;
      if (reading.user_time != WallTime{}) entry["time-us"] = reading.user_time.time_since_epoch().count();
      out["readings"].push_back(std::move(entry));
    }
    return out;
  }
  json operator()(const Actuate& actuate) const {
    auto out = request(actuate);
    if (actuate.time_to_live.count() > 0) out["ttl-ms"] = actuate.time_to_live.count();
    return out;
  }
  json operator()(const SetProperty& property) const { return request(property); }
  json operator()(const Sample& sample) const {
    json out{{"request", sample.request}, {"period-ms", sample.period.count()}, {"points", json::array()}};
    for (const auto& point : sample.points) {
      json entry;
      point_out(point, entry);
      out["points"].push_back(std::move(entry));
    }
    return out;
  }
  json operator()(const Acknowledge& acknowledge) const {
    return {{"request", acknowledge.request}, {"outcome", to_string(acknowledge.outcome)}, {"text", acknowledge.text}};
  }
  json operator()(const State& state) const {
    json out{{"line", to_string(state.line)}, {"reason", state.reason}, {"counters", state.counters}};
    if (!state.texts.empty()) out["texts"] = state.texts;
    if (!state.finding.empty()) out["finding"] = state.finding;
    return out;
  }
  json operator()(const Opaque& opaque) const { return {{"type", opaque.type}, {"bytes", json::binary(opaque.bytes)}}; }
  json operator()(const Probe& probe) const { return (*this)(probe.known); }
  json operator()(const Unreachable& unreachable) const { return {{"reason", unreachable.reason}}; }

 private:
  template <class Request>
  static json request(const Request& body) {
    json out{{"request", body.request}, {"value", value_to_json(body.value)}};
    point_out(body.point, out);
    return out;
  }
};

Join join_in(FieldReader& in) {
  Join join{in.text("device-type", 255), in.text("name", 255), in.text("model", 255), {}, true};
  if (in.has("heard")) join.heard = in.boolean("heard");
  join.id = in.text("id", 255);
  join.problem = in.text("problem");
  join.area = in.text("area", 255);
  in.each("capabilities", [&join](FieldReader& item) { join.capabilities.push_back(capability_in(item)); });
  return join;
}

Updates updates_in(FieldReader& in) {
  Updates updates;
  if (in.has("heard")) updates.heard = in.boolean("heard");
  in.each("readings", [&updates](FieldReader& item) {
    const WallTime time{std::chrono::microseconds(item.signed_number("time-us"))};
    updates.readings.push_back({point_in(item), item.value("value"), time, item.text("why")});
  });
  return updates;
}

Sample sample_in(FieldReader& in) {
  Sample sample{in.number("request", kAny64), {}, std::chrono::milliseconds(in.number("period-ms", 86'400'000'000ULL))};
  in.each("points", [&sample](FieldReader& item) { sample.points.push_back(point_in(item)); });
  return sample;
}

Actuate actuate_in(FieldReader& in) {
  Actuate actuate{in.number("request", kAny64), point_in(in), in.value("value")};
  if (in.has("ttl-ms")) actuate.time_to_live = std::chrono::milliseconds(in.number("ttl-ms", kMaxDeadlineTime));
  return actuate;
}

Body body_in(MessageKind kind, FieldReader in) {
  switch (kind) {
    case MessageKind::kJoin: return join_in(in);
    case MessageKind::kKeepAlive: return KeepAlive{};
    case MessageKind::kLeave: return Leave{in.text("reason")};
    case MessageKind::kUpdates: return updates_in(in);
    case MessageKind::kActuate: return actuate_in(in);
    case MessageKind::kSample: return sample_in(in);
    case MessageKind::kSetProperty: return SetProperty{in.number("request", kAny64), point_in(in), in.value("value")};
    case MessageKind::kAcknowledge:
      return Acknowledge{in.number("request", kAny64), word_in(in, "outcome", Outcome::kBusy), in.text("text")};
    case MessageKind::kState:
      return State{word_in(in, "line", LineState::kRefused), in.text("reason"), in.counters("counters"),
                   in.texts("texts"), in.text("finding", 64)};
    case MessageKind::kOpaque: return Opaque{in.text("type", 255), in.bytes("bytes")};
    case MessageKind::kProbe: return Probe{join_in(in)};
    case MessageKind::kUnreachable: return Unreachable{in.text("reason")};
  }
  return KeepAlive{};
}

}  // namespace

bool is_message_media_type(std::string_view media_type) {
  return media_type == kMessageMediaType || media_type == "rubicon/application" || media_type == "application/rubicon";
}

Bytes to_cbor(const Message& message) {
  json out{{"v", kFormVersion},
           {"origin", number(message.origin)},
           {"number", message.number},
           {"hops", message.hops},
           {"from", address_out(message.source)},
           {"to", address_out(message.destination)},
           {"kind", to_string(message.kind())},
           {"body", std::visit(BodyWriter{}, message.body)}};
  if (message.sender) out["sender"] = sender_out(*message.sender);
  return json::to_cbor(out);
}

Result<Message> from_cbor(ByteView bytes) {
  if (bytes.size() > kMaxMessageBytes) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("message: {} bytes, at most {} are allowed", bytes.size(), kMaxMessageBytes));
  }
  if (auto sound = check_cbor(bytes); !sound) return fail(sound.error());
  const auto form = json::from_cbor(bytes.begin(), bytes.end(), true, false);
  if (form.is_discarded()) return fail(ErrorCode::kInvalid, "message: not CBOR");
  Error error{ErrorCode::kInvalid, {}};
  FieldReader in(form, "", error);
  if (in.ok() && in.number("v", kAny64) != kFormVersion) in.wrong("v", "version 1");
  Message message;
  message.origin = OwnerId(static_cast<std::uint32_t>(in.number("origin", UINT32_MAX)));
  message.number = in.number("number", kAny64);
  message.hops = static_cast<std::uint8_t>(in.number("hops", UINT8_MAX));
  message.source = address_in(in.map("from"));
  message.destination = address_in(in.map("to"));
  if (in.has("sender")) message.sender = sender_in(in.map("sender"));
  const auto kind = word_in(in, "kind", MessageKind::kUnreachable);
  if (in.ok()) message.body = body_in(kind, in.map("body"));
  if (!in.ok()) return fail(std::move(error));
  return message;
}

}  // namespace rubicon::model
