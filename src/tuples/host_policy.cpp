#include "tuples/host_policy.h"

#include <fmt/format.h>

#include "base/local_time.h"

namespace rubicon::tuples {

namespace {

std::string start_text(std::uint64_t microseconds) {
  return base::utc_text(WallTime(std::chrono::microseconds(microseconds)), "%Y-%m-%d %H:%M");
}

}  // namespace

Result<void> HostPolicy::check_clock(WallTime now) {
  if (now >= WallTime(std::chrono::microseconds(kEarliest))) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("the clock of this host says {} UTC: other components ignore those of this process until it "
                          "is set",
                          base::utc_text(now, "%Y-%m-%d %H:%M")));
}

Result<void> HostPolicy::check_start(OwnerId peer, std::uint64_t incarnation) {
  if (incarnation >= kEarliest) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("component {} says that it started on {} UTC, before the clock of its host was set: it takes "
                          "part when that clock is set",
                          number(peer), start_text(incarnation)));
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
