#include "tuples/host_policy.h"

#include <fmt/format.h>

namespace rubicon::tuples {

Result<void> HostPolicy::may_join(const PeerIdentity& peer) {
  if (starts_ == Starts::kAnyNumber || peer.incarnation >= kEarliest) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("component {} gives {} us after 1970 as its start: expected a time after 1999, set the "
                          "clock of its host",
                          number(peer.id), peer.incarnation));
}

void HostPolicy::peer_down(OwnerId peer) {
  hosts_.erase(peer);
  refusal_logged_.erase(peer);
}

std::string_view HostPolicy::host(OwnerId peer) const {
  const auto found = hosts_.find(peer);
  return found == hosts_.end() ? std::string_view() : found->second;
}

Result<void> HostPolicy::may_set(const RemoteSet& set) {
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

}  // namespace rubicon::tuples
