#include "client/reading.h"

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

Reading::Reading(Scheduler& scheduler, TupleSpace& space, const Acquaintance& acquaintance, Pattern pattern,
                 TuplesCall call, Duration patience)
    : scheduler_(scheduler),
      space_(space),
      acquaintance_(acquaintance),
      pattern_(std::move(pattern)),
      call_(std::move(call)) {
  subscription_ = space_.subscribe(
      pattern_, {{}, {}, 0, true}, [](const tuples::Event&) {},
      [this](OwnerId owner) {
        told_.insert(owner);
        check();
      });
  peers_ = space_.watch_peers([this](OwnerId peer, tuples::PeerEvent) {
    told_.erase(peer);
    check();
  });
  patience_ = scheduler_.after(patience, [this] { end(); });
  again_ = scheduler_.after(Duration(0), [this] { check(); });
}

bool Reading::complete() const {
  const auto has_told = [this](OwnerId id) { return told_.contains(id); };
  const auto there = space_.peers();
  if (pattern_.owner) {
    const bool present = std::find(there.begin(), there.end(), *pattern_.owner) != there.end();
    return !present || has_told(*pattern_.owner);
  }
  return std::all_of(there.begin(), there.end(), has_told);
}

void Reading::check() {
  if (over_ || !complete()) return;
  const auto settled_at = acquaintance_.settled_at(pattern_.owner);
  if (scheduler_.now() >= settled_at) return end();
  again_ = scheduler_.at(settled_at, [this] { check(); });
}

void Reading::end() {
  if (std::exchange(over_, true)) return;
  std::vector<Tuple> found;
  space_.list(pattern_, [&](const tuples::TupleView& tuple) { found.emplace_back(tuple); });
  subscription_.reset();
  peers_.reset();
  const auto call = std::move(call_);
  call(std::move(found));  // may end this
}

}  // namespace rubicon::client
