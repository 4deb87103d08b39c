#include "proxy/admission/command_transfer.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>

#include "gateway/message_rights.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/point_tuples.h"
#include "model/type_names.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::proxy::admission {

namespace {

using PlainTree = nlohmann::json;

constexpr std::size_t kMaxTransfer = 32 * 1024;
constexpr std::size_t kMaxInstance = 255;
/// How long the status of a failed transfer is published.
constexpr Duration kFailureShown = std::chrono::seconds(10);
constexpr Duration kRateTravels = std::chrono::seconds(10);

std::optional<std::uint64_t> whole(const PlainTree& tree, const char* name, std::uint64_t most) {
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_number_unsigned()) return std::nullopt;
  const auto value = found->get<std::uint64_t>();
  return value <= most ? std::optional(value) : std::nullopt;
}

/// What became of a command that the other island did not apply.
std::pair<CommandState, std::string> outcome(OwnerId island, const tuples::Reply& reply) {
  if (reply.verdict == tuples::Verdict::kExpired || reply.verdict == tuples::Verdict::kTimedOut) {
    return {CommandState::kTimedOut,
            fmt::format("the device moved to island {}, which did not answer in time", number(island))};
  }
  return {CommandState::kFailed,
          fmt::format("the device moved to island {}, which refused it: {}", number(island), reply.text)};
}

}  // namespace

std::string waiting_command_text(const WaitingCommand& command) {
  const PlainTree tree{{"kind", to_string(command.point.kind)}, {"type", static_cast<unsigned>(command.point.type)},
                       {"instance", command.point.instance},    {"value", command.value},
                       {"creator", number(command.creator)},    {"request", command.request}};
  return model::dump(tree);
}

Result<WaitingCommand> parse_waiting_command(std::string_view text) {
  const auto tree = text.size() > kMaxTransfer ? PlainTree(PlainTree::value_t::discarded) : model::parse_json(text);
  const auto wrong = [](std::string_view what) {
    return fail(ErrorCode::kInvalid, fmt::format("a command that follows its device needs {}", what));
  };
  if (!tree.is_object()) return wrong("a JSON object of at most 32 KiB");
  const auto kind = model::parse_kind(model::text_of(tree, "kind"));
  if (!kind || *kind == Kind::kSensor) return wrong("kind actuator or property");
  const auto type = whole(tree, "type", std::numeric_limits<std::uint16_t>::max());
  const auto instance = model::find_text(tree, "instance");
  if (!type || !instance || instance->size() > kMaxInstance) return wrong("a type number and an instance");
  auto value = model::find_text(tree, "value");
  if (!value) return wrong("a value");
  const auto creator = whole(tree, "creator", std::numeric_limits<std::uint32_t>::max());
  const auto request = whole(tree, "request", std::numeric_limits<std::uint64_t>::max());
  if (!creator || !request) return wrong("creator and request, whole numbers");
  return WaitingCommand{model::current_point({*kind, TypeId{static_cast<std::uint16_t>(*type)}, *instance}),
                        std::move(*value), OwnerId(static_cast<std::uint32_t>(*creator)), *request};
}

/// The sampling period is a setting of the island, not of the device. A period that a user set moves with the device,
/// as a command whose outcome is not awaited.
void CommandTransfer::send_rate(Device& device, const Claim& to, const std::string& tuple) {
  const auto* point = find_point(device, device.rate_point);
  if (!point || !point->storage.set_by_user) return;
  const auto text = waiting_command_text({point->id, std::to_string(device.rate.count()), context_.space.self(), 0});
  context_.space.set_remote(to.island, tuple, text, kRateTravels, nullptr, {.media_type = "application/json"});
}

void CommandTransfer::send(Device& device, const Claim& to, const std::string& tuple) {
  send_rate(device, to, tuple);
  const auto now = context_.clock.now().steady;
  for (auto& released : desk_.release(device)) {
    const auto* point = find_point(device, released->point);
    const auto left = released->expires - now;
    if (!point || left <= Duration(0)) continue;
    const auto text = waiting_command_text({point->id, released->text, released->creator, released->creator_request});
    const std::shared_ptr<Command> command = std::move(released);
    context_.space.set_remote(to.island, tuple, text, left,
                              lifetime_.guard([this, command, status = point_key(device, *point).status(),
                                               island = to.island](const tuples::Reply& reply) {
                                if (reply.verdict != tuples::Verdict::kApplied)
                                  answered(*command, status, island, reply);
                              }),
                              {.media_type = "application/json"});
  }
}

void CommandTransfer::answered(Command& command, const std::string& status, OwnerId island,
                               const tuples::Reply& reply) {
  std::tie(command.state, command.reason) = outcome(island, reply);
  command.since = context_.clock.refresh().wall;
  command.until = {};  // final
  std::string text;
  const auto reason = fmt::format("the device moved to island {}", number(island));
  model::write_point_status({to_string(Quality::kUnknown), reason, command.since, {}, {}, command_text(command)}, text);
  std::ignore = context_.space.set(status, text, {"application/json", {}, kFailureShown, 0});
  context_.commands.warning(fmt::format("{} = {} by {}, id {}: {}", command.key, model::quoted(command.text),
                                        command.commander, number(command.creator), command.reason));
}

void CommandTransfer::clear(const Device& device) {
  if (device.network->rules.roaming.empty()) return;
  for (const auto& point : device.points) {
    const auto status = point_key(device, point).status();
    if (point.mirror.status == TupleRef{} && context_.space.find(status)) std::ignore = context_.space.erase(status);
  }
}

tuples::SetDecision CommandTransfer::decide_set(const tuples::RemoteSet& request) {
  if (request.from != context_.space.self() && !gateway::is_true_island(context_.space, request.from)) {
    return tuples::SetDecision::refused(
        {ErrorCode::kRefused,
         fmt::format("{}: its wire does not vouch for component {} as an island", request.key, number(request.from))});
  }
  const Identity* identity = nullptr;
  auto* device = roaming_.device_of_claim(request.key, identity);
  if (!device) {
    return tuples::SetDecision::refused(
        {ErrorCode::kNotFound, fmt::format("{}: this island lists no such device", request.key)});
  }
  if (request.from != context_.space.self() && !roaming_.claims().has_claimed(*identity, request.from)) {
    return tuples::SetDecision::refused(
        {ErrorCode::kRefused,
         fmt::format("{}: only an island that listed {} before may transfer commands", request.key, device->key)});
  }
  auto command = parse_waiting_command(request.value);
  if (!command) return tuples::SetDecision::refused(std::move(command.error()));
  auto* point = find_point(*device, command->point);
  if (!point) {
    return tuples::SetDecision::refused(
        {ErrorCode::kNotFound,
         fmt::format("{} has no {} of type {} instance {} here", device->key, to_string(command->point.kind),
                     static_cast<unsigned>(command->point.type), command->point.instance)});
  }
  auto as_given = request;
  as_given.key = point_key(*device, *point).command();
  as_given.value = std::move(command->value);
  auto meant = std::make_shared<const tuples::RemoteSet>(as_given);
  as_given.from = command->creator;
  as_given.request = command->request;
  const auto may = may_hand_over(request, as_given.key);
  auto decision = may ? desk_.take_over(as_given, *device, *point) : tuples::SetDecision::refused(may.error());
  decision.meant = std::move(meant);
  return decision;
}

/// The right to set the claim is enough, but an exception for the command itself holds.
Result<void> CommandTransfer::may_hand_over(const tuples::RemoteSet& request, const std::string& command) const {
  const auto* judge = tuples::SpaceRights::judge(context_.space);
  const auto* who = tuples::SpaceRights::asker(context_.space, request);
  if (!judge || !who) return {};
  return judge->may_by_names(*who, tuples::Act::kSet, std::vector{request.key, command});
}

}  // namespace rubicon::proxy::admission
