#include "proxy/kept_outcomes.h"

#include <vector>

namespace rubicon::proxy {

namespace {

/// In bytes of JSON, about.
std::size_t cost(const model::CommandOutcome& outcome) {
  constexpr std::size_t kNames = 80;
  return kNames + outcome.state.size() + outcome.reason.size();
}

}  // namespace

void KeptOutcomes::shown(const Command& command, bool is_final) {
  const Place place{command.device, command.point};
  auto& of = points_[place];
  auto& current = of.current;
  const bool is_other =
      current.outcome.creator != command.creator || current.outcome.request != command.creator_request;
  const bool replaces = is_other && of.is_final;
  if (replaces) keep(of);
  current = {{command.creator, command.creator_request, std::string(to_string(command.state)),
              command.reason.substr(0, kMaxReason)},
             scheduler_.now()};
  of.is_final = is_final;
  if (is_final) next_.advance_to(current.since + kKept);
  if (replaces) tell(place, of);
}

void KeptOutcomes::drop_oldest(OfPoint& of) {
  of.bytes -= cost(of.ended.front().outcome);
  of.ended.pop_front();
  --count_;
}

void KeptOutcomes::keep(OfPoint& of) {
  const auto bytes = cost(of.current.outcome);
  while (!of.ended.empty() && (of.ended.size() >= kMaxPerPoint || of.bytes + bytes > kMaxBytes)) drop_oldest(of);
  if (count_ >= kMaxInAll) return;
  of.ended.push_back(std::move(of.current));
  of.bytes += bytes;
  ++count_;
}

void KeptOutcomes::tell(const Place& place, const OfPoint& of) const {
  std::vector<model::CommandOutcome> outcomes;
  for (const auto& one : of.ended) outcomes.push_back(one.outcome);
  changed_(place, outcomes.empty() ? std::string() : model::command_outcomes_to_json(outcomes));
}

void KeptOutcomes::prune() {
  const auto now = scheduler_.now();
  for (auto at = points_.begin(); at != points_.end();) {
    auto& [place, of] = *at;
    const auto before = of.ended.size();
    while (!of.ended.empty() && of.ended.front().since + kKept <= now) drop_oldest(of);
    if (before != of.ended.size()) tell(place, of);
    const bool is_over = of.ended.empty() && of.is_final && of.current.since + kKept <= now;
    if (!is_over && !of.ended.empty()) next_.advance_to(of.ended.front().since + kKept);
    if (!is_over && of.ended.empty() && of.is_final) next_.advance_to(of.current.since + kKept);
    at = is_over ? points_.erase(at) : std::next(at);
  }
}

void KeptOutcomes::forget(const Place& place) {
  const auto found = points_.find(place);
  if (found == points_.end()) return;
  count_ -= found->second.ended.size();
  points_.erase(found);
}

void KeptOutcomes::forget(DeviceNumber device) {
  for (auto at = points_.lower_bound({device, 0}); at != points_.end() && at->first.first == device;) {
    count_ -= at->second.ended.size();
    at = points_.erase(at);
  }
}

}  // namespace rubicon::proxy
