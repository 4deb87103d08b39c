#include "gateway/message_rights.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/bytes.h"
#include "model/json_members.h"
#include "model/message.h"
#include "model/message_fields.h"
#include "rubicon/key.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::gateway {

namespace {

constexpr std::string_view kIslands = "island:";

Result<void> may_send_to(const tuples::Judge& judge, const tuples::Member& who, const Places& where) {
  if (where.size() == 1) return judge.may_send(who, where.front());
  return judge.may_by_names(who, tuples::Act::kSend, where);
}

/// Longest word of a request that the audit gets.
constexpr std::size_t kMaxWord = 32;

/// Requests of tools have types such as `knx.request` and `zigbee.admin`.
bool may_be_request(const model::Opaque& opaque) {
  return opaque.bytes.size() <= model::kMaxToolRequest &&
         (opaque.type.ends_with(".request") || model::is_admin_type(opaque.type));
}

/// A word, or a number, of the request of a tool.
std::string word_of(const nlohmann::json& request, const char* name) {
  const auto found = request.find(name);
  if (found == request.end() || !found->is_primitive()) return {};
  return (found->is_string() ? found->get<std::string>() : model::dump(*found)).substr(0, kMaxWord);
}

bool is_of_host(const std::string& name) {
  return name.find(':') != name.npos;
}

std::size_t roles_elsewhere(const tuples::Member& who) {
  return who.roles.size() - static_cast<std::size_t>(std::count_if(who.roles.begin(), who.roles.end(), is_of_host));
}

/// Users and groups belong to another host. The component that passed the message on vouches for its user.
void name_for_here(model::Sender& sender, const std::string& voucher) {
  if (is_of_host(voucher)) return;  // an island of this host has the same users
  std::erase_if(sender.roles, is_of_host);
  if (is_of_host(sender.name)) sender.name += "@" + voucher;
}

/// What a message is, for the audit: its content is the business of its receiver. Of a request of a tool also what it
/// does and where: `knx.request write 1/4/6`. Those are JSON with `do`, for networks of all types.
std::string about(const Message& message) {
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (!opaque) return std::string(to_string(message.kind()));
  if (!may_be_request(*opaque)) return opaque->type;
  const auto request = model::object_of(base::as_text(opaque->bytes));
  auto text = opaque->type;
  if (!request.contains("do")) return text;
  for (const auto* name : {"do", "address"}) {
    if (const auto word = word_of(request, name); !word.empty()) text += ' ' + word;
  }
  return text;
}

}  // namespace

std::string_view host_of(TupleSpace& space, const Message& message) {
  const bool came_itself = message.hops <= 1;
  return came_itself ? tuples::SpaceRights::policy(space).host(message.origin) : std::string_view();
}

bool is_true_island(TupleSpace& space, OwnerId component) {
  if (!model::is_island(component)) return false;
  const auto* who = tuples::SpaceRights::member_of(space, component);
  return who == nullptr || who->may_use(component);
}

tuples::Member member_of(const model::Sender& sender, const std::string& through) {
  tuples::Member member;
  member.name = sender.name;
  member.roles = sender.roles;
  member.through = through;
  if (sender.island != model::kNoOwner) member.ids.push_back({number(sender.island), number(sender.island)});
  return member;
}

model::Sender sender_of(const tuples::Member& member) {
  model::Sender sender{member.name, member.roles, model::kNoOwner};
  const auto island = std::find_if(member.ids.begin(), member.ids.end(), [](const tuples::IdRange& one) {
    return one.first == one.last && model::is_island(OwnerId(one.first));
  });
  if (island != member.ids.end()) sender.island = OwnerId(island->first);
  return sender;
}

std::string place_of(const Address& to) {
  if (to.network.empty()) return std::string(kOwn);
  return to.device.empty() ? to.network : fmt::format("{}.{}", to.network, model::to_key_part(to.device));
}

Error may_not_set(const Message& message) {
  return {ErrorCode::kRefused, fmt::format("{} may not set {}", message.sender ? message.sender->name : "its sender",
                                           place_of(message.destination))};
}

Result<Relay> MessageRights::name_sender(OwnerId from, Message& message) const {
  const bool is_relayed = message.hops > 0;
  if (tuples::SpaceRights::judge(space_) == nullptr) {
    message.sender.reset();
    return Relay();
  }
  const auto* who = tuples::SpaceRights::member_of(space_, from);
  if (is_relayed && !is_true_island(space_, from))
    return fail(ErrorCode::kRefused,
                fmt::format("component {} relayed it, but its wire does not vouch for it as an island", number(from)));
  if (is_relayed && message.sender) {
    if (who) name_for_here(*message.sender, who->name);
    return who ? Relay(sender_of(*who)) : Relay();
  }
  if (who) {
    message.sender = sender_of(*who);
  } else {
    message.sender.reset();
  }
  return Relay();
}

Result<void> MessageRights::may_send(const Message& message, const Relay& relay, const Places& where) const {
  auto* judge = tuples::SpaceRights::judge(space_);
  if (judge == nullptr || !message.sender) return {};
  if (auto relayed = may_relay(message, relay, where); !relayed) return relayed;
  const auto who = member_of(*message.sender, relay ? relay->name : std::string());
  auto answer = may_send_to(*judge, who, where);
  if (answer && where.front().starts_with(kIslands) && roles_elsewhere(who) > model::kMaxRoles)
    answer = fail(ErrorCode::kRefused, fmt::format("{} has {} roles, expected at most {} in a message for {}", who.name,
                                                   roles_elsewhere(who), model::kMaxRoles, where.front()));
  if (!answer) record(message, relay, where.front(), answer);
  return answer;
}

void MessageRights::record(const Message& message, const Relay& relay, std::string_view where,
                           const Result<void>& answer) const {
  auto* judge = tuples::SpaceRights::judge(space_);
  if (judge == nullptr || !message.sender) return;
  judge->record(member_of(*message.sender, relay ? relay->name : std::string()),
                {message.origin, host_of(space_, message), "send", where, about(message)}, answer);
}

Result<void> MessageRights::ask(const Message& message, const Relay& relay, const Places& where) const {
  auto* judge = tuples::SpaceRights::judge(space_);
  if (judge == nullptr || !message.sender) return {};
  if (relay) {
    if (auto relayed = judge->would_allow(member_of(*relay), tuples::Act::kSend, where); !relayed) return relayed;
  }
  return judge->would_allow(member_of(*message.sender), tuples::Act::kSend, where);
}

bool MessageRights::is_believed(const Relay& relay, const Places& where) const {
  auto* judge = tuples::SpaceRights::judge(space_);
  return judge == nullptr || !relay || judge->would_allow(member_of(*relay), tuples::Act::kSend, where);
}

Result<void> MessageRights::may_relay(const Message& message, const Relay& relay, const Places& where) const {
  auto* judge = tuples::SpaceRights::judge(space_);
  if (judge == nullptr || !relay) return {};
  const auto who = member_of(*relay);
  auto answer = may_send_to(*judge, who, where);
  if (!answer) {
    answer = fail(answer.error().code, fmt::format("{}, so it passes on nothing from others", answer.error().text));
    judge->record(who, {message.origin, {}, "send", where.front(), about(message)}, answer);
  }
  return answer;
}

}  // namespace rubicon::gateway
