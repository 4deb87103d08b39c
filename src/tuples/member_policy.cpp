#include "tuples/member_policy.h"

#include <fmt/format.h>

namespace rubicon::tuples {

namespace {

Error unknown(OwnerId peer) {
  return {ErrorCode::kRefused, fmt::format("component {} is not authenticated, expected a member", number(peer))};
}

}  // namespace

Result<void> MemberPolicy::may_join(const PeerIdentity& peer) {
  if (peer.own_process) return {};
  if (!peer.member) return fail(unknown(peer.id));
  if (peer.member->is_unproven() || peer.member->may_use(peer.id)) return {};
  return fail(ErrorCode::kRefused, fmt::format("component {} is of member '{}', who does not have that id",
                                               number(peer.id), peer.member->name));
}

void MemberPolicy::peer_up(const PeerIdentity& peer) {
  peers_[peer.id] = {peer.member, peer.own_process, peer.host};
}

bool MemberPolicy::is_own(OwnerId peer) const {
  const auto found = peers_.find(peer);
  return peer == self_ || (found != peers_.end() && found->second.own_process);
}

const Member* MemberPolicy::member(OwnerId peer) const {
  if (peer == kLinkItself) return link_itself_.get();
  const auto found = peers_.find(peer);
  return found == peers_.end() || found->second.own_process ? nullptr : found->second.member.get();
}

/// Behind @ who vouches, so that no rule for `user:ann` of this host is about it.
const Member* MemberPolicy::asker(const RemoteSet& set) {
  const auto* who = is_own(set.from) ? nullptr : member(set.from);
  if (!who || set.asker.empty() || !judge_->may_vouch(*who, set.asker)) return who;
  vouched_ = {};
  vouched_.name = fmt::format("{}@{}", set.asker, who->name.substr(who->name.find(':') + 1));
  vouched_.through = who->name;
  return &vouched_;
}

std::string_view MemberPolicy::host(OwnerId peer) const {
  const auto found = peers_.find(peer);
  return found == peers_.end() ? std::string_view() : found->second.host;
}

/// What it may see is judged tuple by tuple.
Result<void> MemberPolicy::may_subscribe(OwnerId peer, const SubscriptionSpec&) {
  return is_own(peer) || member(peer) ? Result<void>() : fail(unknown(peer));
}

Result<void> MemberPolicy::may_set(const RemoteSet& set) {
  if (is_own(set.from)) return {};
  const auto* who = asker(set);
  return who ? judge_->may_set(*who, set) : fail(unknown(set.from));
}

Result<void> MemberPolicy::may_send(OwnerId peer, std::string_view where) {
  if (is_own(peer)) return {};
  const auto* who = member(peer);
  return who ? judge_->may_send(*who, where) : fail(unknown(peer));
}

void MemberPolicy::answered(const RemoteSet& set, const Reply& reply) {
  const auto found = peers_.find(set.from);
  if (found == peers_.end() || !found->second.member || found->second.own_process) return;
  judge_->answered(*asker(set), found->second.host, set, reply);
}

bool MemberPolicy::filters(OwnerId peer) const {
  if (is_own(peer)) return false;
  const auto* who = member(peer);
  return !who || !judge_->sees_all(*who);
}

Access MemberPolicy::access(OwnerId peer, std::string_view key) const {
  if (is_own(peer)) return {};
  const auto* who = member(peer);
  return who ? judge_->access(*who, key) : Access{false, false, Duration(0)};
}

}  // namespace rubicon::tuples
