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

namespace {

/// A stop of the process counts as one step of the patience.
constexpr Duration kStep = std::chrono::milliseconds(100);

}  // namespace

TupleQuery::TupleQuery(Scheduler& scheduler, TupleSpace& space, PeerDiscovery& peer_discovery, Pattern pattern,
                       TuplesCall call, Duration patience, UnansweredCall unanswered)
    : scheduler_(scheduler),
      space_(space),
      peer_discovery_(peer_discovery),
      pattern_(std::move(pattern)),
      call_(std::move(call)),
      unanswered_call_(std::move(unanswered)),
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
  space_.list(pattern_, [&](const tuples::TupleView& tuple) { found.emplace_back(tuple); });
  subscription_.reset();
  peers_.reset();
  const bool searches = scheduler_.now() < found_at();
  if (const auto left_out = unanswered(); unanswered_call_ && (searches || !left_out.empty()))
    unanswered_call_(left_out);
  const auto call = std::move(call_);
  call(std::move(found));  // may destroy this
}

}  // namespace rubicon::client
