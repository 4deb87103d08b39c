#include <fmt/format.h>

#include "gateway/gateway_tuple.h"
#include "gateway/message_rights.h"
#include "model/point_keys.h"
#include "proxy/command_desk.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"
#include "tuples/peer_policy.h"

// Commands that arrive as messages.

namespace rubicon::proxy {

namespace {

const PointId* point_of(const Message& message) {
  if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) return &actuate->point;
  const auto* set = std::get_if<model::SetProperty>(&message.body);
  return set ? &set->point : nullptr;
}

/// The commanded value.
const Value& value_of(const Message& message) {
  const auto* actuate = std::get_if<model::Actuate>(&message.body);
  return actuate ? actuate->value : std::get<model::SetProperty>(message.body).value;
}

}  // namespace

Result<void> CommandDesk::on_message(const Message& message, const std::string& through) {
  const auto* id = point_of(message);
  if (!id) return fail(ErrorCode::kUnsupported, fmt::format("{} is not a command", to_string(message.kind())));
  Device* device = nullptr;
  const auto point = resolve_target(message, *id, device);
  if (!point) return refuse_unresolved(message, through, device, point.error());
  tuples::RemoteSet request;
  request.from = message.origin;
  request.request = gateway::answerable_number(message);
  request.key = point_key(*device, **point).command();
  write_value((*point)->type, value_of(message), request.value);
  if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) {
    request.time_to_live = actuate->time_to_live;
    request.time_to_live_given = request.time_to_live > Duration(0);
  }
  const auto decision = accept_judged(message, through, request, *device, **point);
  if (decision.verdict != tuples::Verdict::kApplied) return fail(decision.code, decision.text);
  auto& command = *accepted_.back();
  if (!message.source.network.empty())
    command.commander = fmt::format("{} {} of {}", message.source.network, message.source.device, command.commander);
  command.asker = {message.source, message.destination, request.request};
  std::ignore = context_.space.set((*point)->mirror.command, request.value);
  return {};
}

bool CommandDesk::may_command(const Message& message) {
  const auto* judge = tuples::SpaceRights::judge(context_.space);
  const auto* id = point_of(message);
  if (!judge || !message.sender || !id) return true;
  Device* device = nullptr;
  const auto point = resolve_target(message, *id, device);
  if (!point) return device && knows(message, device->key);
  const std::vector key{point_key(*device, **point).command()};
  return judge->would_allow(gateway::member_of(*message.sender), tuples::Act::kSet, key).has_value();
}

/// No tuple belongs to the message: the audit names the device that was meant. The answer does not say whether that
/// device exists, unless the sender may read its description.
Result<void> CommandDesk::refuse_unresolved(const Message& message, const std::string& through, const Device* device,
                                            const Error& why) const {
  if (auto* judge = tuples::SpaceRights::judge(context_.space); judge && message.sender)
    judge->record(
        gateway::member_of(*message.sender, through),
        {message.origin, gateway::host_of(context_.space, message), "set", gateway::place_of(message.destination), {}},
        fail(why));
  const auto& to = message.destination;
  const auto network = model::IslandKey{context_.config.prefix}.network(model::to_key_part(to.network));
  const auto key = device ? device->key : network.device(model::to_key_part(to.device)).text;
  return fail(knows(message, key) ? why : gateway::may_not_set(message));
}

/// Whether its sender may read of the device with that key.
bool CommandDesk::knows(const Message& message, const std::string& device) const {
  const auto* judge = tuples::SpaceRights::judge(context_.space);
  if (!judge || !message.sender) return true;
  return judge->access(gateway::member_of(*message.sender), model::DeviceKey{device}.description()).read;
}

/// Its sender needs the right to set the tuple that the message amounts to; one line of the audit says what came of it.
tuples::SetDecision CommandDesk::accept_judged(const Message& message, const std::string& through,
                                               const tuples::RemoteSet& request, Device& device, Point& point) {
  auto* judge = tuples::SpaceRights::judge(context_.space);
  if (judge == nullptr || !message.sender) return accept(request, device, point);
  const auto who = gateway::member_of(*message.sender, through);
  const auto may = judge->may_set(who, request);
  auto decision = may ? accept(request, device, point) : tuples::SetDecision::refused(may.error());
  judge->answered(who, gateway::host_of(context_.space, message), request,
                  {request.from, request.request, decision.verdict, decision.code, decision.text});
  if (!may && !knows(message, device.key)) return tuples::SetDecision::refused(gateway::may_not_set(message));
  return decision;
}

Result<Point*> CommandDesk::resolve_target(const Message& message, const PointId& id, Device*& device) {
  const auto& to = message.destination;
  const auto network = directory_.networks().find(to.network);
  if (network == directory_.networks().end()) {
    return fail(ErrorCode::kNotFound,
                fmt::format("no network {} on island {}", model::quoted(to.network), number(to.island)));
  }
  device = network->second->devices.find(to.device);
  if (!device)
    return fail(ErrorCode::kNotFound, fmt::format("{} has no device {}", to.network, model::quoted(to.device)));
  auto* point = find_point(*device, id);
  if (!point) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{} has no {} of type {} instance {}", device->key, to_string(id.kind),
                            static_cast<unsigned>(id.type), model::quoted(id.instance)));
  }
  if (point->mirror.command != TupleRef{}) return point;
  return fail(ErrorCode::kRefused, fmt::format("{} of {} cannot be commanded", point->details->id(), device->key));
}

}  // namespace rubicon::proxy
