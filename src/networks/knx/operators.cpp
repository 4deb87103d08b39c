#include "networks/knx/operators.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::networks::knx {

namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr Duration kAnswer = 2s;
constexpr Duration kOperatorLifetime = 5s;
/// Of one reply to `capture`: with the text around them they fit one message.
constexpr std::size_t kFrames = 500, kFrameBytes = 50'000;
/// Of a field of a request: room for the JSON of any type.
constexpr std::size_t kLongestText = 2000;

std::string text_of(const json& wish, const char* key) {
  const auto found = wish.find(key);
  if (found == wish.end()) return {};
  if (found->is_string()) return found->get<std::string>().substr(0, kLongestText);
  return found->is_number() || found->is_boolean() ? found->dump() : std::string();
}

std::string_view word(wire::Service service) {
  switch (service) {
    case wire::Service::kRead: return "read";
    case wire::Service::kResponse: return "response";
    case wire::Service::kWrite: break;
  }
  return "write";
}

/// The value in the words of the KNX table; empty where there is no type or it does not fit.
std::string value_text(const dpt::Dpt* dpt, wire::PayloadView payload) {
  if (!dpt) return {};
  const auto value = decode(*dpt, payload);
  if (!value) return {};
  const auto* number = std::get_if<double>(&*value);
  return label(*dpt, number ? Value(natural(*dpt, *number)) : *value);
}

/// The type named in the request, else the configured one.
Result<const dpt::Dpt*> type_of(const json& wish, const dpt::Dpt* configured) {
  const auto text = text_of(wish, "dpt");
  if (text.empty()) return configured;
  const auto id = dpt::parse_dpt(text);
  if (!id) return fail(id.error());
  const auto* dpt = dpt::find_dpt(*id);
  if (!dpt) return fail(ErrorCode::kNotFound, fmt::format("there is no data point type {}", to_string(*id)));
  return dpt;
}

}  // namespace

Operators::Operators(network::NetworkHost& host, const Capture& capture, Means means, Wrote wrote)
    : host_(host), capture_(capture), means_(std::move(means)), wrote_(std::move(wrote)) {}

void Operators::use(line::Line* line) {
  line_ = line;
  if (line_ != nullptr) return;
  for (const auto& reading : readings_) refuse(reading.asker, "the line to the bus was lost");
  readings_.clear();
}

void Operators::give_up(wire::GroupAddress address, std::string_view why) {
  readings_.remove_if([&](const Reading& one) {
    if (one.address != address) return false;
    refuse(one.asker, why);
    return true;
  });
}

Result<void> Operators::take(const model::Message& message) {
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (!opaque || opaque->type != kRequestTag)
    return fail(ErrorCode::kUnsupported, fmt::format("KNX takes no {}", to_string(message.kind())));
  const auto wish = json::parse(opaque->bytes.begin(), opaque->bytes.end(), nullptr, false);
  if (!wish.is_object()) return fail(ErrorCode::kInvalid, "a knx.request is a JSON object");
  Asker asker{message.source, text_of(wish, "id")};
  const auto what = text_of(wish, "do");
  if (what == "capture") {
    capture(asker, wish);
  } else if (what == "monitor") {
    monitor(std::move(asker), wish);
  } else if (line_ == nullptr && (what == "read" || what == "write")) {
    refuse(asker, "the line to the bus is down");
  } else if (what == "read") {
    read(std::move(asker), wish);
  } else if (what == "write") {
    write(std::move(asker), wish);
  } else {
    refuse(asker, fmt::format("do is {}, expected read, write, monitor or capture", model::quoted(what)));
  }
  return {};
}

void Operators::read(Asker asker, const json& wish) {
  const auto address = wire::parse_group(text_of(wish, "address"));
  if (!address) return refuse(asker, address.error().text);
  const auto dpt = type_of(wish, means_(*address).dpt);
  if (!dpt) return refuse(asker, dpt.error().text);
  if (readings_.size() >= kMostReads) return refuse(asker, "too many questions are open");
  wire::Telegram question;
  question.service = wire::Service::kRead;
  question.destination = *address;
  auto& reading = readings_.emplace_back(Reading{std::move(asker), *address, *dpt, {}});
  reading.patience = host_.scheduler().after(kOperatorLifetime + kAnswer, [this, &reading] {
    refuse(reading.asker, fmt::format("nobody on the bus answers for {}", to_string(reading.address)));
    readings_.remove_if([&](const Reading& one) { return &one == &reading; });
  });
  line_->send(
      std::move(question), host_.scheduler().now() + kOperatorLifetime,
      [this, address = *address, alive = std::weak_ptr<bool>(alive_)](line::SendOutcome outcome, std::string_view why) {
        if (alive.lock() && outcome != line::SendOutcome::kSent && outcome != line::SendOutcome::kUnconfirmed)
          give_up(address, why);
      });
}

void Operators::write(Asker asker, const json& wish) {
  const auto address = wire::parse_group(text_of(wish, "address"));
  if (!address) return refuse(asker, address.error().text);
  const auto dpt = type_of(wish, means_(*address).dpt);
  if (!dpt) return refuse(asker, dpt.error().text);
  if (!*dpt) return refuse(asker, fmt::format("{} has no type here: name one", to_string(*address)));
  auto payload = dpt::encode_text(**dpt, text_of(wish, "value"));
  if (!payload) return refuse(asker, payload.error().text);
  wire::Telegram telegram;
  telegram.destination = *address;
  telegram.payload = *payload;
  telegram.priority = wire::Priority::kNormal;
  const auto hex = base::to_hex(payload->bytes);
  line_->send(telegram, host_.scheduler().now() + kOperatorLifetime,
              [this, asker = std::move(asker), hex, telegram, alive = std::weak_ptr<bool>(alive_)](
                  line::SendOutcome outcome, std::string_view why) {
                if (!alive.lock()) return;
                if (outcome != line::SendOutcome::kSent && outcome != line::SendOutcome::kUnconfirmed)
                  return refuse(asker, why);
                reply(asker, {{"ok", true}, {"address", to_string(telegram.destination)}, {"hex", hex}});
                wrote_(telegram);
              });
}

void Operators::monitor(Asker asker, const json& wish) {
  const auto seconds = wish.value("seconds", json(30));
  const Duration span = std::chrono::seconds(
      seconds.is_number_integer() ? std::clamp<std::int64_t>(seconds.get<std::int64_t>(), 0, 600) : 30);
  monitors_.remove_if(
      [&](const Monitor& one) { return one.asker.address == asker.address && one.asker.id == asker.id; });
  if (monitors_.size() >= kMostMonitors) return refuse(asker, "too many monitors are open");
  if (span > Duration::zero()) {
    auto& added = monitors_.emplace_back(Monitor{asker, {}});
    added.lease = host_.scheduler().after(std::min(span, kLongestMonitor), [this, &added] {
      monitors_.remove_if([&](const Monitor& one) { return &one == &added; });
    });
  }
  reply(asker, {{"ok", true}, {"line", line_ != nullptr}});
}

/// Frames from number `from` on; who asks for the next after the last gets them all.
void Operators::capture(const Asker& asker, const json& wish) {
  const auto from_node = wish.value("from", json(0));
  const auto from = from_node.is_number_unsigned() ? from_node.get<std::uint64_t>() : 0;
  auto frames = json::array();
  const auto& all = capture_.frames();
  auto frame = std::find_if(all.begin(), all.end(), [from](const auto& one) { return one.number >= from; });
  std::size_t bytes = 0;
  for (; frame != all.end() && frames.size() < kFrames && bytes < kFrameBytes; ++frame) {
    bytes += frame->cemi.size();
    frames.push_back({{"number", frame->number},
                      {"time", frame->time.time_since_epoch().count()},
                      {"out", frame->outgoing},
                      {"cemi", base::to_hex(frame->cemi)}});
  }
  reply(asker, {{"ok", true}, {"frames", std::move(frames)}, {"more", frame != all.end()}});
}

json Operators::described(const wire::Telegram& telegram, bool own) const {
  const auto meaning = means_(telegram.destination);
  json out{{"time", base::to_seconds(host_.scheduler().wall_now())},
           {"service", word(telegram.service)},
           {"source", to_string(telegram.source)},
           {"address", to_string(telegram.destination)},
           {"own", own}};
  if (telegram.service != wire::Service::kRead) out["hex"] = base::to_hex(telegram.payload.bytes);
  if (!meaning.name.empty()) out["name"] = meaning.name;
  if (!meaning.dpt || telegram.service == wire::Service::kRead) return out;
  out["dpt"] = to_string(meaning.dpt->id);
  out["value"] = value_text(meaning.dpt, telegram.payload);
  out["unit"] = meaning.dpt->unit;
  return out;
}

void Operators::seen(const wire::Telegram& telegram, bool own) {
  if (!monitors_.empty()) {
    const auto text = described(telegram, own).dump(-1, ' ', false, json::error_handler_t::replace);
    for (const auto& monitor : monitors_) say(monitor.asker.address, kTelegramTag, text);
  }
  if (telegram.service == wire::Service::kRead || own) return;
  readings_.remove_if([&](const Reading& reading) {
    if (reading.address != telegram.destination) return false;
    auto answer = described(telegram, own);
    answer["ok"] = true;
    if (reading.dpt) {
      answer["dpt"] = to_string(reading.dpt->id);
      answer["value"] = value_text(reading.dpt, telegram.payload);
      answer["unit"] = reading.dpt->unit;
    }
    reply(reading.asker, std::move(answer));
    return true;
  });
}

void Operators::refuse(const Asker& asker, std::string_view why) {
  reply(asker, {{"ok", false}, {"why", why}});
}

void Operators::reply(const Asker& asker, json answer) {
  answer["id"] = asker.id;
  say(asker.address, kReplyTag, answer.dump(-1, ' ', false, json::error_handler_t::replace));
}

void Operators::say(const Address& to, std::string_view tag, const std::string& text) {
  model::Message message;
  message.destination = to;
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(tag), Bytes(bytes.begin(), bytes.end())};
  host_.deliver(std::move(message));
}

}  // namespace rubicon::networks::knx
