#include "networks/wsn/upkeep.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "motes/mote_records.h"

namespace rubicon::networks::wsn {

Result<void> MoteProbes::probe(std::uint16_t mote, DoneCallback done) {
  const auto lost = lost_.find(mote);
  const bool is_lost = lost != lost_.end();
  if (is_lost && scheduler_.now() < lost->second.due)
    return fail(ErrorCode::kDuplicate,  // it is planned: nothing is lost
                fmt::format("mote {} did not answer its last probe: the next one follows after a pause", mote));
  if (!pending_.insert(mote).second)
    return fail(ErrorCode::kDuplicate, fmt::format("a probe of mote {} is under way", mote));
  (is_lost ? lost_waiting_ : waiting_).push_back({mote, std::move(done), is_lost ? kAttempts - 1 : 0, is_lost});
  next();
  return {};
}

void MoteProbes::next() {
  while (under_way_ < kMaxConcurrent && !(waiting_.empty() && silent_.empty()))
    start_first(waiting_.empty() ? silent_ : waiting_);
  while (lost_under_way_ < kMaxConcurrentLost && !lost_waiting_.empty()) start_first(lost_waiting_);
}

void MoteProbes::start_first(std::deque<Probe>& queue) {
  auto probe = std::move(queue.front());
  queue.pop_front();
  if (start(probe)) return;
  // The lane is full: the proxy probes again later.
  pending_.erase(probe.mote);
  probe.done(DeliveryResult::kExpired);
}

bool MoteProbes::start(Probe probe) {
  auto request = probe_request(island_, probe.mote);
  ++probe.attempts;
  auto& under_way = probe.lost ? lost_under_way_ : under_way_;
  request.done = [this, &under_way, probe = std::move(probe)](DeliveryResult result) {
    --under_way;
    ended(probe, result);
    next();
  };
  if (!requests_.send(std::move(request))) return false;
  ++under_way;
  ++sent_;
  return true;
}

void MoteProbes::ended(Probe probe, DeliveryResult result) {
  const bool silent = result == DeliveryResult::kNoAnswer || result == DeliveryResult::kSinkSilent;
  if (silent && probe.attempts < kAttempts) return silent_.push_back(std::move(probe));
  pending_.erase(probe.mote);
  if (result == DeliveryResult::kNoAnswer) {
    auto& lost = lost_[probe.mote];
    lost.pause = lost.pause == Duration::zero() ? kFirstPause : std::min(2 * lost.pause, kMaxPause);
    lost.due = scheduler_.now() + lost.pause;
  }
  probe.done(result);
}

Bytes IslandIdKeeper::packet() const {
  return motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, island_}));
}

void IslandIdKeeper::repeat(std::optional<Duration> period) {
  next_.cancel();
  if (!period) return;
  next_ = scheduler_.after(*period, [this, period] {
    std::ignore = send_({packet(), sink::Lane::kProbe, scheduler_.now() + *period, true, {}});
    repeat(period);
  });
}

void IslandIdKeeper::correct() {
  const auto now = scheduler_.now();
  if (corrected_ && now < *corrected_ + kMinPause) return;
  corrected_ = now;
  std::ignore = send_({packet(), sink::Lane::kCommand, now + kMinPause, true, {}});
}

}  // namespace rubicon::networks::wsn
