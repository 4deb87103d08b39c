#include "tuples/demand_watches.h"

#include <limits>

namespace rubicon::tuples {

std::shared_ptr<DemandWatches::Watch> DemandWatches::add(const Pattern& pattern, DemandCall call) {
  any_new_ = true;
  return watches_.emplace_back(std::make_shared<Watch>(Watch{pattern, std::move(call)}));
}

void DemandWatches::remove(const std::shared_ptr<Watch>& watch) {
  watch->alive = false;
  std::erase(watches_, watch);
}

DemandState DemandWatches::demand_of(std::uint32_t index) const {
  return store_.at(index).present ? store_.subscribers(index).demand : DemandState{};
}

void DemandWatches::note(std::uint32_t index, const DemandState& before) {
  if (watches_.empty() || demand_of(index) == before) return;
  if (!before_.emplace(index, before).second) return;
  order_.push_back(index);
  store_.pool().pin(index);
}

void DemandWatches::drain() {
  const auto before = std::exchange(before_, {});
  for (const auto index : std::exchange(order_, {})) {
    report_change(index, before.at(index));
    store_.pool().unpin(index);
  }
  if (!std::exchange(any_new_, false)) return;
  for (const auto& watch : std::vector(watches_)) {
    if (watch->alive && std::exchange(watch->is_new, false)) report_present(*watch);
  }
}

void DemandWatches::report_change(std::uint32_t index, const DemandState& before) {
  const auto now = demand_of(index);
  if (now == before) return;
  for (const auto& watch : std::vector(watches_)) {
    if (watch->alive && !watch->is_new && watch->pattern.matches(self_, store_.at(index).key()))
      report(*watch, index, now);
  }
}

void DemandWatches::report_present(Watch& watch) {
  auto pattern = watch.pattern;
  if (pattern.owner && *pattern.owner != self_) return;
  pattern.owner = self_;
  PatternWalk walk(store_.trie(), pattern);
  auto budget = std::numeric_limits<std::size_t>::max();
  while (const auto index = walk.next(budget)) {
    if (!watch.alive) return;
    const auto demand = demand_of(*index);
    if (demand.wanted) report(watch, *index, demand);
  }
}

void DemandWatches::report(Watch& watch, std::uint32_t index, const DemandState& demand) {
  const auto& tuple = store_.at(index);
  store_.pool().pin(index);
  watch.call(Demand{{index, tuple.generation}, tuple.key(), demand.wanted, demand.interval, demand.named});
  store_.pool().unpin(index);
}

}  // namespace rubicon::tuples
