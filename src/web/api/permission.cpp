#include "web/api/permission.h"

#include <fmt/format.h>

#include <utility>

#include "gateway/message_rights.h"
#include "model/json_members.h"
#include "rubicon/key.hpp"
#include "transport/host_names.h"
#include "web/access/token_file.h"
#include "web/api/tracked_set.h"

namespace rubicon::web::api {

namespace {

constexpr std::string_view kMessages = "GATEWAY";

/// The owner would judge a message by the rights of this process, which may do everything.
bool is_message(std::string_view key) {
  const auto first = key.substr(0, key.find('.'));
  return first == kMessages || first == "RUBICON_GATEWAY";
}

std::string_view text_of(Verb verb) {
  switch (verb) {
    case Verb::kRead: return "read";
    case Verb::kWake: return "wake the sensors of";
    case Verb::kSet: return "set";
    case Verb::kSend: break;
  }
  return "send messages of type";
}

/// The word of the right.
std::string_view right_of(Verb verb) {
  return verb == Verb::kWake ? "demand" : verb == Verb::kSend ? "send" : text_of(verb);
}

tuples::Member member_of(const Caller& caller) {
  tuples::Member member;
  member.name = caller.name;
  member.roles = caller.roles;
  member.roles.emplace_back(access::to_string(caller.role));
  return member;
}

tuples::RemoteSet remote_set_of(const SetRequest& request) {
  tuples::RemoteSet set;
  set.owner = request.owner;
  set.key = request.key;
  set.value = request.value;
  set.media_type = request.media_type;
  set.append = request.append;
  return set;
}

/// The island would find the network by the device only after the rights were asked.
Result<void> check_address(const Address& to) {
  if (!to.network.empty() || to.device.empty()) return {};
  return fail(ErrorCode::kInvalid, fmt::format("network is missing; expected the id of the network that has device {}",
                                               model::quoted(to.device)));
}

/// What people call points is kept with what they arrange on the page (docs/tuple-keys.md), and needs what the name of
/// a device needs.
bool gives_names(const SetRequest& request) {
  const auto dot = request.key.find('.');
  return dot != std::string::npos && request.key.substr(dot) == ".overview" &&
         model::object_of(request.value).contains("names");
}

Result<void> check_names(const Caller& caller, const SetRequest& request) {
  if (caller.role >= Role::kAdmin || !gives_names(request)) return {};
  return fail(ErrorCode::kRefused, fmt::format("{} has the role {}, which may not set the names of points",
                                               model::quoted(caller.name), access::to_string(caller.role)));
}

Error lacks(const Caller& caller, std::string_view right, std::string_view key) {
  return {ErrorCode::kRefused, fmt::format("{} may not {} {}: no rule allows it", caller.name, right, key)};
}

}  // namespace

Result<void> Permission::check_role(const Caller& caller, Verb verb, OwnerId owner, std::string_view key) const {
  if (may(caller, verb, owner, key)) return {};
  return fail(ErrorCode::kRefused, fmt::format("{} has the role {}, which may not {} {}", model::quoted(caller.name),
                                               access::to_string(caller.role), text_of(verb), key));
}

void Permission::record(const Caller& caller, std::string_view verb, std::string_view key,
                        const Result<void>& answer) const {
  if (judge_) judge_->record(member_of(caller), {model::kNoOwner, caller.peer, verb, key, {}}, answer);
}

Result<void> Permission::check_read(const Caller& caller, Verb verb, OwnerId owner, std::string_view key) const {
  auto answer = check_role(caller, verb, owner, key);
  const bool is_pattern = key.find('*') != key.npos;
  if (answer && judge_ && !is_pattern) {
    const auto given = access(caller, key);
    if (verb == Verb::kWake ? !given.demand : !given.read) answer = fail(lacks(caller, right_of(verb), key));
  }
  if (!answer) record(caller, right_of(verb), key, answer);
  return answer;
}

Result<void> Permission::check_listen(const Caller& caller, OwnerId self, std::string_view type) const {
  if (auto answer = check_role(caller, Verb::kRead, self, type); !answer) {
    record(caller, right_of(Verb::kRead), kMessages, answer);
    return answer;
  }
  return check_read(caller, Verb::kRead, self, kMessages);
}

Result<void> Permission::check_decisions(const Caller& caller, std::string_view inbox, const Result<void>& can) const {
  auto answer = check_role(caller, Verb::kSet, model::kNoOwner, inbox);
  if (answer) answer = can;
  if (!answer) record(caller, "approve", inbox, answer);
  return answer;
}

/// Whoever reaches the port is the caller where there are no tokens: what changes the file of the configuration, which
/// names files and lines, is for this host.
Result<void> Permission::check_place(const Caller& caller, std::string_view key, std::string_view value) const {
  const bool changes_file = key.ends_with(".settings.command") && value != "try" && value != "reload";
  if (knows_callers_ || !changes_file || transport::is_loopback_address(caller.peer)) return {};
  return fail(ErrorCode::kRefused,
              "without tokens the file of the configuration is changed from its own host only (web: {tokens: ...})");
}

Result<void> Permission::check_set(const Caller& caller, const SetRequest& request, const Result<void>& can) const {
  auto answer = check_role(caller, Verb::kSet, request.owner, request.key);
  if (answer) answer = check_names(caller, request);
  if (answer) answer = check_place(caller, request.key, request.value);
  if (answer) answer = can;
  if (!judge_) return answer;
  const auto member = member_of(caller);
  const auto set = remote_set_of(request);
  if (answer && is_message(request.key))
    answer =
        fail(ErrorCode::kRefused, fmt::format("{} may not set {}: expected the verb `send` of the socket for messages",
                                              caller.name, model::quoted(request.key)));
  if (answer) answer = judge_->may_set(member, set);
  if (!answer)
    judge_->answered(member, caller.peer, set,
                     {{}, 0, tuples::Verdict::kRefused, answer.error().code, answer.error().text});
  return answer;
}

Result<void> Permission::check_send(const Caller& caller, const Address& to, std::string_view type,
                                    const Result<void>& can) const {
  auto answer = check_role(caller, Verb::kSend, to.island, type);
  if (answer) answer = can;
  if (!judge_) return answer;
  const auto where = place_of(to);
  if (answer && to.island == island_) answer = check_address(to);
  if (answer) answer = judge_->may_send(member_of(caller), where);
  if (!answer) judge_->record(member_of(caller), {model::kNoOwner, caller.peer, "send", where, type}, answer);
  return answer;
}

std::string Permission::place_of(const Address& to) const {
  return to.island == island_ ? gateway::place_of(to) : fmt::format("island:{}", number(to.island));
}

std::function<void(const std::string& why_not)> Permission::send_recorder(const Caller& caller, const Address& to,
                                                                          std::string_view type) const {
  if (!judge_) return nullptr;
  return [judge = judge_, member = member_of(caller), peer = caller.peer, where = place_of(to),
          type = std::string(type)](const std::string& why_not) {
    judge->record(member, {model::kNoOwner, peer, "send", where, type},
                  why_not.empty() ? Result<void>() : fail(ErrorCode::kUnreachable, why_not));
  };
}

bool Permission::sees_all(const Caller& caller) const {
  return judge_ == nullptr || judge_->sees_all(member_of(caller));
}

tuples::Access Permission::access(const Caller& caller, std::string_view key) const {
  return judge_ ? judge_->access(member_of(caller), key) : tuples::Access{};
}

tuples::Handle Permission::speak_for(const Caller& caller, OwnerId self, std::uint64_t request) const {
  return judge_ ? judge_->speak_for(member_of(caller), self, request) : tuples::Handle();
}

std::function<void(const tuples::Reply&)> Permission::recorder(const SetRequest& request) const {
  if (!judge_) return nullptr;
  return [judge = judge_, member = member_of(request.caller), peer = request.caller.peer,
          set = remote_set_of(request)](const tuples::Reply& reply) { judge->answered(member, peer, set, reply); };
}

}  // namespace rubicon::web::api
