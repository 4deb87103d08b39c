#include "client/tuple_query.h"

#include <algorithm>
#include <utility>

namespace rubicon::client {

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

TupleQuery::TupleQuery(Scheduler& scheduler, TupleSpace& space, const PeerDiscovery& peer_discovery, Pattern pattern,
                       TuplesCall call, Duration patience)
    : scheduler_(scheduler),
      space_(space),
      peer_discovery_(peer_discovery),
      pattern_(std::move(pattern)),
      call_(std::move(call)) {
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
  patience_ = scheduler_.after(patience, [this] { end(); });
  again_ = scheduler_.after(Duration(0), [this] { check(); });
}

bool TupleQuery::complete() const {
  const auto has_answered = [this](OwnerId id) { return answered_.contains(id); };
  const auto there = space_.peers();
  if (pattern_.owner) {
    const bool present = std::find(there.begin(), there.end(), *pattern_.owner) != there.end();
    return !present || has_answered(*pattern_.owner);
  }
  return std::all_of(there.begin(), there.end(), has_answered);
}

void TupleQuery::check() {
  if (over_ || !complete()) return;
  const auto complete_at = peer_discovery_.complete_at(pattern_.owner);
  if (scheduler_.now() >= complete_at) return end();
  again_ = scheduler_.at(complete_at, [this] { check(); });
}

void TupleQuery::end() {
  if (std::exchange(over_, true)) return;
  std::vector<Tuple> found;
  space_.list(pattern_, [&](const tuples::TupleView& tuple) { found.emplace_back(tuple); });
  subscription_.reset();
  peers_.reset();
  const auto call = std::move(call_);
  call(std::move(found));  // may destroy this
}

}  // namespace rubicon::client
