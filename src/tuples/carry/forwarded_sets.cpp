#include "tuples/carry/forwarded_sets.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples::carry {

std::uint64_t ForwardedSets::add(OwnerId owner, std::size_t asked, std::size_t goes, const RemoteSet& set,
                                 SteadyTime now, WallTime wall) {
  if (requests_.size() >= kMax || waiting_bytes_ + set.value.size() > kMaxWaitingBytes) return 0;
  last_ = std::max(static_cast<std::uint64_t>(wall.time_since_epoch().count()), last_ + 1);
  const auto lives = set.time_to_live > Duration(0) ? std::min(set.time_to_live, kMaxTime) : kMaxTime;
  auto& request = requests_[last_] = {owner, set.from, asked, goes, last_, set.request, 0, now + lives, set};
  request.waiting->owner = owner;
  waiting_[{owner, set.from}].insert(last_);
  ++of_reader_[{set.from, goes}];
  waiting_bytes_ += set.value.size();
  return last_;
}

ForwardedSets::Request* ForwardedSets::find(std::uint64_t number) {
  const auto found = requests_.find(number);
  return found == requests_.end() ? nullptr : &found->second;
}

std::uint64_t ForwardedSets::wire_number(const Request& request, std::uint64_t last) const {
  const bool is_free =
      request.original > last && !of_wire_.contains({{request.reader, request.goes}, request.original});
  return is_free ? request.original : std::max(request.number, last + 1);
}

std::uint64_t ForwardedSets::answered(OwnerId reader, std::size_t goes, std::uint64_t wire) const {
  const auto found = of_wire_.find({{reader, goes}, wire});
  return found == of_wire_.end() ? 0 : found->second;
}

void ForwardedSets::sent(Request& request, std::uint64_t wire) {
  stop_waiting(request);
  request.wire = wire;
  of_wire_[{{request.reader, request.goes}, wire}] = request.number;
}

void ForwardedSets::stop_waiting(Request& request) {
  if (!request.waiting) return;
  const Way way{request.owner, request.reader};
  auto& waits = waiting_[way];
  waits.erase(request.number);
  if (waits.empty()) waiting_.erase(way);
  waiting_bytes_ -= request.waiting->value.size();
  request.waiting.reset();
}

std::optional<ForwardedSets::Request> ForwardedSets::take(std::uint64_t number) {
  const auto found = requests_.find(number);
  if (found == requests_.end()) return {};
  auto taken = found->second;
  stop_waiting(found->second);
  const StandIn reader{taken.reader, taken.goes};
  of_wire_.erase({reader, taken.wire});
  requests_.erase(found);
  if (--of_reader_[reader] == 0) of_reader_.erase(reader);
  return taken;
}

std::uint64_t ForwardedSets::first_waiting(OwnerId owner, OwnerId reader) const {
  const auto found = waiting_.find({owner, reader});
  return found == waiting_.end() ? 0 : *found->second.begin();
}

std::vector<ForwardedSets::Request> ForwardedSets::take_due(SteadyTime now) {
  std::vector<std::uint64_t> due;
  for (const auto& [number, request] : requests_) {
    if (request.due <= now) due.push_back(number);
  }
  std::vector<Request> taken;
  for (const auto number : due) taken.push_back(*take(number));
  return taken;
}

void ForwardedSets::forget(OwnerId component, std::size_t engine) {
  std::vector<std::uint64_t> gone;
  for (const auto& [number, request] : requests_) {
    const bool asks = request.reader == component && request.goes == engine;
    if (asks || (request.owner == component && request.asked == engine)) gone.push_back(number);
  }
  for (const auto number : gone) take(number);
}

SteadyTime ForwardedSets::next_due() const {
  auto next = SteadyTime::max();
  for (const auto& one : requests_) next = std::min(next, one.second.due);
  return next;
}

}  // namespace rubicon::tuples::carry
