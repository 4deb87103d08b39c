#include "client/tuple_query.h"

#include <algorithm>
#include <utility>

#include "tuples/peer_policy.h"

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

/// By a link that knows whom it has not met. The link looks for it from now on.
bool PeerDiscovery::is_sought(std::optional<OwnerId> owner) const {
  return tuples::SpaceRights::seeks(space_, owner);
}

SteadyTime PeerDiscovery::next_look() const {
  return scheduler_.now() + (pace_.is_fact ? kLookAtHost : kLookAgain);
}

std::optional<bool> PeerDiscovery::has(OwnerId owner) const {
  if (present(owner)) return true;
  const bool expected = is_sought(owner) || (expects_ && expects_(owner));
  return pace_.is_fact && !expected ? std::optional(false) : std::nullopt;
}

SteadyTime PeerDiscovery::complete_at(OwnerId owner, Duration patience) {
  if (has(owner)) return started_;
  notice_stop();
  if (pace_.is_fact) return next_look();
  return is_sought(owner) ? std::max(next_look(), started_ + patience) : started_ + patience;
}

SteadyTime PeerDiscovery::complete_at() {
  notice_stop();
  const bool sought = is_sought(std::nullopt), expected = expects_ && expects_(std::nullopt);
  if (left_alone_ && !pace_.is_fact) return started_ + std::max(pace_.expected, kReturn);
  const auto usual = std::max(last_change_ + pace_.quiet, started_ + pace_.search);
  if (sought) return std::max(usual, next_look());
  const auto now = scheduler_.now(), longest = started_ + pace_.expected;
  if (usual > now || now >= longest || !expected) return usual;
  return std::min(next_look(), longest);
}

Tuple::Tuple(const tuples::TupleView& view)
    : owner(view.owner),
      key(view.key),
      value(view.value),
      media_type(view.media_type),
      creator(view.creator),
      sequence(view.sequence),
      write_time(view.write_time),
      user_time(view.user_time),
      expire_time(view.expire_time),
      owner_present(view.owner_present) {}

namespace {

/// A stop of the process counts as one step of the patience.
constexpr Duration kStep = std::chrono::milliseconds(100);

}  // namespace

TupleQuery::TupleQuery(Scheduler& scheduler, TupleSpace& space, PeerDiscovery& peer_discovery, Pattern pattern,
                       TuplesCall call, Duration patience, UnansweredCall unanswered, Wanted wanted)
    : scheduler_(scheduler),
      space_(space),
      peer_discovery_(peer_discovery),
      pattern_(std::move(pattern)),
      call_(std::move(call)),
      unanswered_call_(std::move(unanswered)),
      wanted_(std::move(wanted)),
      whole_patience_(patience) {
  subscription_ = space_.subscribe(
      pattern_, {{}, {}, 0, true}, [](const tuples::Event&) {},
      [this](OwnerId owner) {
        answered_.insert(owner);
        check();
      });
  peers_ = space_.watch_peers([this](OwnerId peer, tuples::PeerEvent) {
    answered_.erase(peer);
    check();
  });
  wait(patience);
  again_ = scheduler_.after(Duration(0), [this] { check(); });
}

void TupleQuery::wait(Duration patience) {
  const auto step = std::min(patience, kStep);
  patience_ = scheduler_.after(step, [this, left = patience - step] { left > Duration(0) ? wait(left) : end(); });
}

/// Those who are present.
std::vector<OwnerId> TupleQuery::unanswered() const {
  auto them = space_.peers();
  std::erase_if(them, [this](OwnerId id) { return answered_.contains(id) || id != pattern_.owner.value_or(id); });
  return them;
}

/// When all whose tuples are meant are discovered.
SteadyTime TupleQuery::found_at() {
  return pattern_.owner ? peer_discovery_.complete_at(*pattern_.owner, whole_patience_) : peer_discovery_.complete_at();
}

void TupleQuery::check() {
  if (over_ || !unanswered().empty()) return;
  const auto complete_at = found_at();
  if (scheduler_.now() >= complete_at) return end();
  again_ = scheduler_.at(complete_at, [this] { check(); });
}

void TupleQuery::end() {
  if (std::exchange(over_, true)) return;
  std::vector<Tuple> found;
  space_.list(pattern_, [&](const tuples::TupleView& tuple) {
    if (!wanted_ || wanted_(tuple)) found.emplace_back(tuple);
  });
  subscription_.reset();
  peers_.reset();
  const bool searches = scheduler_.now() < found_at();
  if (const auto left_out = unanswered(); unanswered_call_ && (searches || !left_out.empty()))
    unanswered_call_(left_out);
  const auto call = std::move(call_);
  call(std::move(found));  // may destroy this
}

}  // namespace rubicon::client
