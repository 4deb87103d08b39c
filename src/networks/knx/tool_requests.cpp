#include "networks/knx/tool_requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/json_members.h"
#include "model/json_text.h"
#include "model/message_fields.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx {

namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr Duration kToolAnswerTime = 2s;
constexpr Duration kToolTelegramLifetime = 5s;
/// Bounds of one reply to `capture`, so that it fits one message.
constexpr std::size_t kMaxReplyFrames = 500, kMaxReplyBytes = 50'000;
/// Bound of a field of a request: enough for the JSON of any data point type.
constexpr std::size_t kMaxRequestText = 2000;

std::string field_text(const json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end()) return {};
  if (found->is_string()) return found->get<std::string>().substr(0, kMaxRequestText);
  return found->is_number() || found->is_boolean() ? model::dump(*found) : std::string();
}

std::string_view word(wire::Service service) {
  switch (service) {
    case wire::Service::kRead: return "read";
    case wire::Service::kResponse: return "response";
    case wire::Service::kWrite: break;
  }
  return "write";
}

/// Type, unit and value in the words of the KNX table, empty where it does not fit. A number that has no word stands
/// beside it as `number`.
void add_value(const dpt::Dpt& dpt, wire::PayloadView payload, json& out) {
  out["dpt"] = to_string(dpt.id);
  out["unit"] = dpt.unit;
  out["value"] = "";
  out.erase("number");
  auto value = decode(dpt, payload);
  if (!value) return;
  if (auto* number = std::get_if<double>(&*value)) *number = natural(dpt, *number);
  const auto text = label(dpt, *value);
  out["value"] = text;
  if (text != model::to_text(*value)) return;
  if (const auto* real = std::get_if<double>(&*value)) out["number"] = *real;
  if (const auto* whole = std::get_if<std::int64_t>(&*value)) out["number"] = *whole;
}

/// The type named in the request, else the configured one.
Result<const dpt::Dpt*> type_of(const json& request, const dpt::Dpt* configured) {
  const auto text = field_text(request, "dpt");
  if (text.empty()) return configured;
  const auto id = dpt::parse_dpt(text);
  if (!id) return fail(id.error());
  const auto* dpt = dpt::find_dpt(*id);
  if (!dpt) return fail(ErrorCode::kNotFound, fmt::format("there is no data point type {}", to_string(*id)));
  return dpt;
}

}  // namespace

ToolRequests::ToolRequests(network::NetworkHost& host, const Capture& capture, FindMeaning find_meaning,
                           FindCommand find_command, Wrote wrote)
    : host_(host),
      capture_(capture),
      find_meaning_(std::move(find_meaning)),
      find_command_(std::move(find_command)),
      wrote_(std::move(wrote)),
      monitors_(host) {}

void ToolRequests::use(line::Line* line) {
  line_ = line;
  if (line_ != nullptr) return;
  for (const auto& reading : reads_) refuse(reading.requester, "the line to the bus was lost");
  reads_.clear();
}

void ToolRequests::give_up(wire::GroupAddress address, std::string_view why) {
  reads_.remove_if([&](const OpenRead& one) {
    if (one.address != address) return false;
    refuse(one.requester, why);
    return true;
  });
}

Result<void> ToolRequests::receive(const model::Message& message) {
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (!opaque || opaque->type != kRequestTag)
    return fail(ErrorCode::kUnsupported, fmt::format("KNX does not support {}", to_string(message.kind())));
  const auto object = model::read_tool_request(*opaque);
  if (!object) return fail(object.error());
  const auto& request = *object;
  Requester requester{message.source, field_text(request, "id"), message.sender.has_value()};
  const auto what = field_text(request, "do");
  if (what == "capture") {
    capture(requester, request);
  } else if (what == "monitor") {
    monitor(requester, request);
  } else if (line_ == nullptr && (what == "read" || what == "write")) {
    refuse(requester, "the line to the bus is down");
  } else if (what == "read") {
    read(std::move(requester), request);
  } else if (what == "write") {
    write(std::move(requester), request);
  } else {
    refuse(requester, fmt::format("do is {}, expected read, write, monitor or capture", model::quoted(what)));
  }
  return {};
}

void ToolRequests::read(Requester requester, const json& request) {
  const auto address = wire::parse_group(field_text(request, "address"));
  if (!address) return refuse(requester, address.error().text);
  const auto dpt = type_of(request, find_meaning_(*address).dpt);
  if (!dpt) return refuse(requester, dpt.error().text);
  if (reads_.size() >= kMaxReads) return refuse(requester, "too many reads are open");
  wire::Telegram telegram;
  telegram.service = wire::Service::kRead;
  telegram.destination = *address;
  auto& reading = reads_.emplace_back(OpenRead{std::move(requester), *address, *dpt, {}});
  reading.timeout = host_.scheduler().after(kToolTelegramLifetime + kToolAnswerTime, [this, &reading] {
    refuse(reading.requester,
           fmt::format("no device on the bus answers for {}", find_meaning_(reading.address).address));
    reads_.remove_if([&](const OpenRead& one) { return &one == &reading; });
  });
  line_->send(std::move(telegram), host_.scheduler().now() + kToolTelegramLifetime,
              [this, address = *address, watch = lifetime_.watch()](line::SendOutcome outcome, std::string_view why) {
                if (!watch.ended() && outcome != line::SendOutcome::kSent && outcome != line::SendOutcome::kUnconfirmed)
                  give_up(address, why);
              });
}

void ToolRequests::write(Requester requester, const json& request) {
  const auto address = wire::parse_group(field_text(request, "address"));
  if (!address) return refuse(requester, address.error().text);
  if (const auto command = requester.is_member ? find_command_(*address) : std::string(); !command.empty())
    return refuse(requester, fmt::format("messages cannot command actuators, and {} commands one: set {} instead",
                                         find_meaning_(*address).address, command));
  const auto dpt = type_of(request, find_meaning_(*address).dpt);
  if (!dpt) return refuse(requester, dpt.error().text);
  if (!*dpt)
    return refuse(requester,
                  fmt::format("{} has no configured type: the request must name one", find_meaning_(*address).address));
  auto payload = dpt::encode_text(**dpt, field_text(request, "value"));
  if (!payload) return refuse(requester, payload.error().text);
  wire::Telegram telegram;
  telegram.destination = *address;
  telegram.payload = *payload;
  telegram.priority = wire::Priority::kNormal;
  const auto hex = base::to_hex(payload->bytes);
  line_->send(
      telegram, host_.scheduler().now() + kToolTelegramLifetime,
      [this, requester = std::move(requester), hex, telegram, watch = lifetime_.watch()](line::SendOutcome outcome,
                                                                                         std::string_view why) {
        if (watch.ended()) return;
        if (outcome != line::SendOutcome::kSent && outcome != line::SendOutcome::kUnconfirmed)
          return refuse(requester, why);
        reply(requester, {{"ok", true}, {"address", find_meaning_(telegram.destination).address}, {"hex", hex}});
        wrote_(telegram);
      });
}

void ToolRequests::monitor(const Requester& requester, const json& request) {
  if (auto asked = monitors_.ask(requester.address, requester.id, request); !asked)
    return refuse(requester, asked.error().text);
  reply(requester, {{"ok", true}, {"line", line_ != nullptr}});
}

/// Frames from number `from` on; a tool reads them all by repeated requests.
void ToolRequests::capture(const Requester& requester, const json& request) {
  const auto from_node = request.value("from", json(0));
  const auto from = from_node.is_number_unsigned() ? from_node.get<std::uint64_t>() : 0;
  auto frames = json::array();
  const auto& all = capture_.frames();
  auto frame = std::find_if(all.begin(), all.end(), [from](const auto& one) { return one.number >= from; });
  std::size_t bytes = 0;
  for (; frame != all.end() && frames.size() < kMaxReplyFrames && bytes < kMaxReplyBytes; ++frame) {
    bytes += frame->cemi.size();
    frames.push_back({{"number", frame->number},
                      {"time", frame->time.time_since_epoch().count()},
                      {"out", frame->outgoing},
                      {"cemi", base::to_hex(frame->cemi)}});
  }
  reply(requester, {{"ok", true}, {"frames", std::move(frames)}, {"more", frame != all.end()}});
}

json ToolRequests::described(const wire::Telegram& telegram, bool own) const {
  const auto meaning = find_meaning_(telegram.destination);
  json out{{"time", base::to_seconds(host_.scheduler().wall_now())},
           {"service", word(telegram.service)},
           {"source", to_string(telegram.source)},
           {"address", meaning.address},
           {"own", own},
           {"secured", meaning.secured}};
  if (telegram.service != wire::Service::kRead) out["hex"] = base::to_hex(telegram.payload.bytes);
  if (!meaning.name.empty()) out["name"] = meaning.name;
  if (!meaning.dpt || telegram.service == wire::Service::kRead) return out;
  add_value(*meaning.dpt, telegram.payload, out);
  return out;
}

void ToolRequests::seen(const wire::Telegram& telegram, bool own) {
  if (monitors_.any()) monitors_.send(kTelegramTag, model::dump(described(telegram, own)));
  if (telegram.service == wire::Service::kRead || own) return;
  reads_.remove_if([&](const OpenRead& reading) {
    if (reading.address != telegram.destination) return false;
    auto answer = described(telegram, own);
    answer["ok"] = true;
    if (reading.dpt) add_value(*reading.dpt, telegram.payload, answer);
    reply(reading.requester, std::move(answer));
    return true;
  });
}

void ToolRequests::refuse(const Requester& requester, std::string_view why) {
  reply(requester, {{"ok", false}, {"why", why}});
}

void ToolRequests::reply(const Requester& requester, json answer) {
  answer["id"] = requester.id;
  network::send_text(host_, requester.address, kReplyTag, model::dump(answer));
}

}  // namespace rubicon::networks::knx
