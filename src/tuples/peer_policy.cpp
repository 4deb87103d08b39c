#include "tuples/peer_policy.h"

#include <fmt/format.h>

#include "base/clocks.h"

namespace rubicon::tuples {

namespace {

std::string start_text(std::uint64_t microseconds) {
  return base::utc_text(WallTime(std::chrono::microseconds(microseconds)), "%Y-%m-%d %H:%M");
}

}  // namespace

Result<void> DeclaredHostPolicy::check_clock(WallTime now) {
  if (now >= WallTime(std::chrono::microseconds(kEarliest))) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("the clock of this host says {} UTC: other components ignore this process until the clock "
                          "is set",
                          base::utc_text(now, "%Y-%m-%d %H:%M")));
}

Result<void> DeclaredHostPolicy::check_start(OwnerId peer, std::uint64_t incarnation) {
  if (incarnation >= kEarliest) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("component {} says that it started on {} UTC, before the clock of its host was set: it takes "
                          "part when that clock is set",
                          number(peer), start_text(incarnation)));
}

void DeclaredHostPolicy::peer_down(OwnerId peer) {
  hosts_.erase(peer);
  refusal_logged_.erase(peer);
}

std::string_view DeclaredHostPolicy::host(OwnerId peer) const {
  const auto found = hosts_.find(peer);
  return found == hosts_.end() ? std::string_view() : found->second;
}

Result<void> DeclaredHostPolicy::may_set(const RemoteSet& set) {
  const auto found = hosts_.find(set.from);
  if (trusts_others_ || (found != hosts_.end() && found->second == own_host_)) return {};
  if (refusal_logged_.insert(set.from).second) {
    log_.warning(
        fmt::format("remote sets of component {} are refused: it runs on another host, and tuples.trust_lan is no",
                    number(set.from)));
  }
  return fail(
      ErrorCode::kRefused,
      fmt::format("setting '{}': component {} accepts no remote sets from other hosts (its tuples.trust_lan is no)",
                  set.key, number(self_)));
}

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

/// Its rights to read are judged for each tuple.
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
