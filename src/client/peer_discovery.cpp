#include "client/peer_discovery.h"

#include <algorithm>
#include <utility>

namespace rubicon::client {

namespace {

/// While components are expected: by DDS, and by processes of this host.
constexpr Duration kLookAgain = std::chrono::milliseconds(20), kLookAtHost = std::chrono::milliseconds(1);
/// Pause between two observations. A pause of more than twice that means that the process was stopped; it counts as
/// one.
constexpr Duration kObserve = std::chrono::milliseconds(50);
/// A component that was lost is met again by one of its next two announcements (DDS: SPDP, at most a lease of 2 s
/// apart).
constexpr Duration kReturn = std::chrono::seconds(4);

}  // namespace

PeerDiscovery::PeerDiscovery(Scheduler& scheduler, TupleSpace& space, const DiscoveryPace& pace, Expects expects)
    : scheduler_(scheduler),
      space_(space),
      pace_(pace),
      expects_(std::move(expects)),
      started_(scheduler.now()),
      last_change_(started_),
      noticed_(started_) {
  peers_ = space.watch_peers([this](OwnerId, tuples::PeerEvent event) {
    notice_stop();
    last_change_ = scheduler_.now();
    left_alone_ = event == tuples::PeerEvent::kLost && space_.peers().empty();
    if (left_alone_) started_ = last_change_;
    if (!observes_) observe();
  });
  observe();
}

/// Repeats itself until all bounds of the pace have passed.
void PeerDiscovery::observe() {
  if (pace_.is_fact) return;
  notice_stop();
  observes_ =
      noticed_ < std::max(last_change_ + pace_.quiet, started_ + std::max({pace_.search, pace_.expected, kReturn}));
  if (observes_) again_ = scheduler_.after(kObserve, [this] { observe(); });
}

void PeerDiscovery::notice_stop() {
  const auto now = scheduler_.now(), before = std::exchange(noticed_, now);
  if (!observes_ || now - before <= 2 * kObserve) return;
  const auto lost = now - before - kObserve;
  started_ += lost;
  last_change_ += lost;
}

bool PeerDiscovery::present(OwnerId id) const {
  const auto there = space_.peers();
  return id == space_.self() || std::find(there.begin(), there.end(), id) != there.end();
}

std::optional<bool> PeerDiscovery::has(OwnerId owner) const {
  if (present(owner)) return true;
  const bool expected = expects_ && expects_(owner);
  return pace_.is_fact && !expected ? std::optional(false) : std::nullopt;
}

SteadyTime PeerDiscovery::complete_at(OwnerId owner, Duration patience) {
  if (has(owner)) return started_;
  notice_stop();
  return pace_.is_fact ? scheduler_.now() + kLookAtHost : started_ + patience;
}

SteadyTime PeerDiscovery::complete_at() {
  notice_stop();
  const bool expected = expects_ && expects_(std::nullopt);
  if (left_alone_ && !pace_.is_fact) return started_ + std::max(pace_.expected, kReturn);
  const auto usual = std::max(last_change_ + pace_.quiet, started_ + pace_.search);
  const auto now = scheduler_.now(), longest = started_ + pace_.expected;
  if (usual > now || now >= longest || !expected) return usual;
  return std::min(now + (pace_.is_fact ? kLookAtHost : kLookAgain), longest);
}

}  // namespace rubicon::client
