#include "tuples/demand_watches.h"

#include <limits>

namespace rubicon::tuples {

std::shared_ptr<DemandWatches::Watch> DemandWatches::add(const Pattern& pattern, DemandCall call) {
  any_fresh_ = true;
  return watches_.emplace_back(std::make_shared<Watch>(Watch{pattern, std::move(call)}));
}

void DemandWatches::remove(const std::shared_ptr<Watch>& watch) {
  watch->alive = false;
  std::erase(watches_, watch);
}

Want DemandWatches::want_of(std::uint32_t index) const {
  return store_.at(index).present ? store_.subscribers(index).want : Want{};
}

void DemandWatches::note(std::uint32_t index, const Want& before) {
  if (watches_.empty() || want_of(index) == before) return;
  if (!before_.emplace(index, before).second) return;
  order_.push_back(index);
  store_.pool().pin(index);
}

void DemandWatches::drain() {
  const auto before = std::exchange(before_, {});
  for (const auto index : std::exchange(order_, {})) {
    tell_change(index, before.at(index));
    store_.pool().unpin(index);
  }
  if (!std::exchange(any_fresh_, false)) return;
  for (const auto& watch : std::vector(watches_)) {
    if (watch->alive && std::exchange(watch->fresh, false)) tell_present(*watch);
  }
}

void DemandWatches::tell_change(std::uint32_t index, const Want& before) {
  const auto now = want_of(index);
  if (now == before) return;
  for (const auto& watch : std::vector(watches_)) {
    if (watch->alive && !watch->fresh && watch->pattern.matches(self_, store_.at(index).key()))
      tell(*watch, index, now);
  }
}

void DemandWatches::tell_present(Watch& watch) {
  auto pattern = watch.pattern;
  if (pattern.owner && *pattern.owner != self_) return;
  pattern.owner = self_;
  PatternWalk walk(store_.trie(), pattern);
  auto budget = std::numeric_limits<std::size_t>::max();
  while (const auto index = walk.next(budget)) {
    if (!watch.alive) return;
    const auto want = want_of(*index);
    if (want.wanted) tell(watch, *index, want);
  }
}

void DemandWatches::tell(Watch& watch, std::uint32_t index, const Want& want) {
  const auto& tuple = store_.at(index);
  store_.pool().pin(index);
  watch.call(Demand{{index, tuple.generation}, tuple.key(), want.wanted, want.interval, want.named});
  store_.pool().unpin(index);
}

}  // namespace rubicon::tuples
