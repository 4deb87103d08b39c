#include "rights/rights_judge.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::rights {

namespace {

using tuples::Member;

bool is_at_or_below(std::string_view key, std::string_view top) {
  return key.starts_with(top) && (key.size() == top.size() || key[top.size()] == '.');
}

/// The gateway judges the messages that arrive there, each by what it asks for.
bool is_message(std::string_view key) {
  return is_at_or_below(key, "GATEWAY") || is_at_or_below(key, "RUBICON_GATEWAY");
}

/// Of a command that follows its device: the island reports what it amounts to.
bool is_claim(std::string_view key) {
  return is_at_or_below(key, "ROAMING");
}

std::string_view doing(Right right) {
  return right == Right::kSend ? "send to" : to_string(right);
}

}  // namespace

RightsJudge::RightsJudge(Rights rights, std::shared_ptr<Audit> audit, std::string_view prefix,
                         std::vector<std::string> operators)
    : rights_(std::move(rights)),
      audit_(std::move(audit)),
      inbox_(fmt::format("{}.inbox", prefix)),
      operators_(std::move(operators)) {}

/// The kernel vouches for a user of this host. For a user of another host a member does.
bool RightsJudge::is_operator(const Member& who) const {
  return who.through.empty() &&
         std::any_of(operators_.begin(), operators_.end(), [&](const auto& user) { return who.has_role(user); });
}

bool RightsJudge::is_of_inbox(std::string_view key) const {
  return is_at_or_below(key, inbox_);
}

tuples::Access RightsJudge::access(const Member& who, std::string_view key) const {
  return is_operator(who) ? tuples::Access() : rights_.access(who, key);
}

bool RightsJudge::sees_all(const Member& who) const {
  return is_operator(who) || rights_.sees_all(who);
}

Result<void> RightsJudge::answer(const Member& who, Right right, std::string_view key) const {
  const auto decision = explain(who, right, key);
  if (decision.allowed) return {};
  ++refused_;
  return fail(refusal(who, right, key, decision));
}

Error RightsJudge::refusal(const Member& who, Right right, std::string_view key, const Decision& decision) const {
  const auto needed = right == Right::kSet ? needed_to_set(key) : right;
  return {ErrorCode::kRefused, fmt::format("{} may not {} {}: {}", who.name, doing(needed), key, decision.text)};
}

Result<void> RightsJudge::may_by_names(const Member& who, tuples::Act act, std::span<const std::string> names) const {
  auto answer = would_allow(who, act, names);
  if (!answer) ++refused_;
  return answer;
}

Result<void> RightsJudge::would_allow(const Member& who, tuples::Act act, std::span<const std::string> names) const {
  const auto right = act == tuples::Act::kSet ? Right::kSet : Right::kSend;
  bool allowed = false;
  for (const auto& name : names) {
    const auto decision = explain(who, right, name);
    if (!decision.allowed && decision.rule) return fail(refusal(who, right, name, decision));
    allowed |= decision.allowed;
  }
  if (allowed) return {};
  return fail(refusal(who, right, names.front(), explain(who, right, names.front())));
}

tuples::Handle RightsJudge::speak_for(const Member& who, OwnerId component, std::uint64_t request) {
  const Request key{component, request};
  spoken_for_->insert_or_assign(key, who);
  return tuples::Handle([all = spoken_for_, key] { all->erase(key); });
}

const Member* RightsJudge::spoken_for(OwnerId component, std::uint64_t request) const {
  const auto found = spoken_for_->find({component, request});
  return found == spoken_for_->end() ? nullptr : &found->second;
}

Result<void> RightsJudge::may_set(const Member& who, const tuples::RemoteSet& set) const {
  return answer(who, Right::kSet, set.key);
}

Result<void> RightsJudge::may_send(const Member& who, std::string_view where) const {
  return answer(who, Right::kSend, where);
}

Decision RightsJudge::explain(const Member& who, Right right, std::string_view key) const {
  if (is_operator(who)) return {true, std::nullopt, "root and the user of the island may do everything"};
  if (right != Right::kSet) return rights_.decide(who, right, kept_key(key));
  if (is_message(key)) return {true, std::nullopt, "each message is judged by what it asks for"};
  return rights_.decide(who, needed_to_set(key), kept_key(key));
}

/// Recognises a refusal by the rules by its text. Other refusals have another text, which may quote the value. For a
/// command that follows its device the rules were asked about the claim, so their answer for the key does not matter.
bool RightsJudge::refused_by_rules(const Member& who, std::string_view key, const tuples::Reply& reply) const {
  const auto decision = explain(who, Right::kSet, key);
  return !decision.allowed && reply.text == refusal(who, Right::kSet, key, decision).text;
}

void RightsJudge::answered(const Member& who, std::string_view host, const tuples::RemoteSet& set,
                           const tuples::Reply& reply) {
  const bool accepted = reply.verdict == tuples::Verdict::kApplied;
  if (!audit_ || (accepted && is_message(set.key))) return;
  const auto verb = is_message(set.key)    ? to_string(Right::kSend)
                    : is_of_inbox(set.key) ? to_string(Right::kApprove)
                    : set.append           ? "append"
                                           : to_string(Right::kSet);
  const auto value = is_message(set.key) || is_claim(set.key) ? std::string_view() : std::string_view(set.value);
  const auto key = kept_key(set.key);
  audit_->write(
      {who, set.from, host, verb, key, value, accepted, accepted ? std::string_view() : std::string_view(reply.text),
       accepted ? std::string_view() : to_string(reply.code), !accepted && !refused_by_rules(who, set.key, reply)});
}

void RightsJudge::record(const Member& who, const tuples::OtherRequest& request, const Result<void>& answer) {
  if (!audit_) return;
  const auto key = kept_key(request.key);
  audit_->write({who, request.component, request.host, request.verb, key, request.value, answer.has_value(),
                 answer ? std::string_view() : std::string_view(answer.error().text),
                 answer ? std::string_view() : to_string(answer.error().code)});
}

}  // namespace rubicon::rights
