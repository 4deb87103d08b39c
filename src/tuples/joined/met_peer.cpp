#include "tuples/joined/joined_link.h"

#include <algorithm>
#include <utility>

#include "tuples/link.h"

namespace rubicon::tuples::joined {

namespace {

/// What vouches for a meeting; a higher value counts more. Nothing proves that the carrier of a stand-in tells the
/// truth.
enum class Proof : std::uint8_t { kOwnWord, kUser, kKernel, kOwnProcess };

Proof proof_of(const PeerIdentity& one) {
  const bool itself = !is_stand_in(one);
  if (one.own_process && itself) return Proof::kOwnProcess;
  if (one.by_kernel && itself) return Proof::kKernel;
  return !one.member || one.member->is_unproven() ? Proof::kOwnWord : Proof::kUser;
}

/// Whether `one` is, for all that engines prove, what `other` is.
bool proves(const PeerIdentity& one, const PeerIdentity& other) {
  const auto proof = proof_of(other);
  if (proof == Proof::kOwnWord) return true;
  if (proof_of(one) != proof) return false;
  return proof > Proof::kUser || one.member->name == other.member->name;
}

/// Whether `one` is the component `other`, as another engine sees it.
bool is_same(const PeerIdentity& one, const PeerIdentity& other) {
  return one.incarnation == other.incarnation && proves(one, other);
}

}  // namespace

bool is_restart(const PeerIdentity& before, const PeerIdentity& news) {
  return !news.host.empty() && news.host == before.host && news.incarnation > before.incarnation;
}

MetPeer::Move MetPeer::meet(std::size_t engine, const PeerIdentity& identity, bool barred) {
  for (auto& other : meetings_) {
    if (other && other->identity.incarnation == identity.incarnation) other->left = false;
  }
  meetings_[engine].emplace().identity = identity;
  meetings_[engine]->barred = barred;
  if (barred) return {};
  if (!home_) return live_at(engine);
  const auto& resident = meetings_[*home_]->identity;
  if (!comes_before(engine, identity)) return {};
  Move move{resident, PeerEvent::kLost, {}, false};
  move.up = live_at(engine).up;
  return move;
}

/// Whether the component is to live on this engine, and no longer where it lives.
bool MetPeer::comes_before(std::size_t engine, const PeerIdentity& news) const {
  const auto& resident = meetings_[*home_]->identity;
  if (proof_of(news) != proof_of(resident)) return proof_of(news) > proof_of(resident);
  if (is_stand_in(news)) return false;
  if (is_stand_in(resident)) return true;
  return resident.incarnation == news.incarnation ? engine < *home_ : is_restart(resident, news);
}

MetPeer::Move MetPeer::part(std::size_t engine, PeerEvent how) {
  const auto identity = meetings_[engine]->identity;
  meetings_[engine].reset();
  if (home_ != engine) return {};
  for (auto& other : meetings_) {
    if (how != PeerEvent::kLeft || !other) continue;
    if (other->identity.incarnation == identity.incarnation || is_stand_in(other->identity)) other->left = true;
  }
  Move move{identity, how, live_at(next_home(identity.incarnation)).up, false};
  move.was_rival = move.up && !is_same(meetings_[*move.up]->identity, identity);
  return move;
}

/// That with the best proof first; then the same component before its stand-in, that before a rival, then by the order
/// of the engines.
std::optional<std::size_t> MetPeer::next_home(std::uint64_t incarnation) const {
  const auto rank = [incarnation](const PeerIdentity& one) {
    return std::pair(proof_of(one), one.incarnation == incarnation ? 2 : is_stand_in(one) ? 1 : 0);
  };
  std::optional<std::size_t> next;
  for (std::size_t engine = 0; engine < meetings_.size(); ++engine) {
    const auto* meeting = at(engine);
    if (!meeting || meeting->left || meeting->barred) continue;
    if (!next || rank(meeting->identity) > rank(meetings_[*next]->identity)) next = engine;
  }
  return next;
}

MetPeer::Move MetPeer::live_at(std::optional<std::size_t> engine) {
  home_ = engine;
  if (engine && stream_ && !is_same(stream_->sender, meetings_[*engine]->identity)) stream_.reset();
  return {{}, PeerEvent::kUp, engine, false};
}

bool MetPeer::is_resident(std::size_t engine) const {
  return home_ && meetings_[engine] && !meetings_[engine]->left && !meetings_[engine]->barred &&
         is_same(meetings_[engine]->identity, meetings_[*home_]->identity);
}

bool MetPeer::is_forgotten() const {
  return std::none_of(meetings_.begin(), meetings_.end(), [](const auto& meeting) { return meeting.has_value(); });
}

std::optional<std::size_t> MetPeer::rival_of(std::size_t engine) const {
  const auto* meeting = at(engine);
  if (!meeting || meeting->left || meeting->barred || is_stand_in(meeting->identity)) return {};
  for (std::size_t other = 0; other < meetings_.size(); ++other) {
    const auto* rival = at(other);
    if (!rival || rival->left || rival->barred || is_stand_in(rival->identity)) continue;
    if (rival->identity.incarnation != meeting->identity.incarnation) return other;
  }
  return {};
}

bool MetPeer::begin_stream(std::size_t engine, const Restart& restart) {
  if (restart.since == WallTime{}) return counts(engine);
  const bool later = !stream_ || stream_->engine == engine || restart.since > stream_->since;
  if (later) stream_ = {engine, at(engine)->identity, restart.since};
  return later;
}

}  // namespace rubicon::tuples::joined
