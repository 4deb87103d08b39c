#include "proxy/user_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/json_text.h"
#include "proxy/commander.h"
#include "proxy/naming.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

using nlohmann::json;

constexpr std::string_view kForm = R"(expected {"name": TEXT, "area": TEXT}, one of them or both; "" removes it)";

/// A name that a user may give: no control characters, not longer than the state file keeps.
Result<std::string> given_text(const json& value, const std::string& what) {
  if (!value.is_string()) return fail(ErrorCode::kInvalid, fmt::format("{}: {}", what, kForm));
  auto text = value.get<std::string>();
  if (text.size() > state::kMaxGiven) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} bytes, at most {} are kept", what, text.size(), state::kMaxGiven));
  }
  const bool control = std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  if (control)
    return fail(ErrorCode::kInvalid, fmt::format("{}: a control character in {}", what, model::quoted(text)));
  return text;
}

}  // namespace

tuples::SetDecision UserNames::decide_set(const tuples::RemoteSet& request) {
  const auto head = context_.config.prefix.size() + 1;
  const auto parts = std::string_view(request.key).substr(head, request.key.rfind('.') - head);
  auto* device = directory_.find_by_key(parts);
  const auto refused = [](Error why) { return tuples::SetDecision::refused(std::move(why)); };
  if (!device)
    return refused({ErrorCode::kNotFound, fmt::format("{}: no such device here", model::quoted(request.key))});
  const auto tree = model::parse_json(request.value);
  if (!tree.is_object() || tree.empty())
    return refused({ErrorCode::kInvalid, fmt::format("{}: {}", request.key, kForm)});
  auto name = device->given_name.text(), area = device->given_area.text();
  for (const auto& [member, value] : tree.items()) {
    auto* target = member == "name" ? &name : member == "area" ? &area : nullptr;
    if (!target) {
      return refused(
          {ErrorCode::kRefused, fmt::format("{}: users cannot set {}; {}", request.key, model::quoted(member), kForm)});
    }
    auto text = given_text(value, fmt::format("{}: {}", request.key, member));
    if (!text) return refused(std::move(text.error()));
    const auto* fixed = names_of(device->network->rules, device->address);
    const bool taken = fixed && !(target == &name ? fixed->name : fixed->area).empty();
    if (taken && !text->empty()) {
      return refused(
          {ErrorCode::kRefused, fmt::format("the configuration gives {} its {}: change networks.{}.devices.{}.{} there",
                                            device->key, member, device->network->id, device->address, member)});
    }
    *target = std::move(*text);
  }
  if (auto done = give(*device, std::move(name), std::move(area), request.from); !done) return refused(done.error());
  return tuples::SetDecision::consumed();
}

Result<void> UserNames::give(Device& device, std::string name, std::string area, OwnerId by) {
  auto name_before = std::exchange(device.given_name, RareText()),
       area_before = std::exchange(device.given_area, RareText());
  device.given_name = std::move(name);
  device.given_area = std::move(area);
  if (auto done = memory_.save_names(device); !done) {
    device.given_name = std::move(name_before);
    device.given_area = std::move(area_before);
    return fail(done.error().code, fmt::format("{} keeps its name: {}", device.key, done.error().text));
  }
  if (directory_.update_name(device)) mirror_.described(device);
  context_.log.info(fmt::format("{} is called {} in area {} by {}, id {}", device.key, model::quoted(device.name),
                                model::quoted(device.area.text()), commander_name(context_.space, context_.config, by),
                                number(by)));
  return {};
}

}  // namespace rubicon::proxy
