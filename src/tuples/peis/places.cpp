#include "tuples/peis/places.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples::peis {

namespace {

constexpr Duration kPlaceTime = std::chrono::seconds(5);  ///< for a connection that shows where a kernel runs
/// Requests of one that did not show it wait again.
constexpr Duration kForgetPlace = std::chrono::minutes(1);
constexpr std::size_t kMaxPlaceless = 64, kMaxHeld = 256, kMaxHeldOfOne = 32, kMaxHeldBytes = 1'000'000;

}  // namespace

Places::Places(NodeContext& context, const Hosts& hosts, const Routes& routes, const NodeLinks& links, Dialer& dialer,
               std::function<void(const Package&)> take)
    : context_(context),
      hosts_(hosts),
      routes_(routes),
      links_(links),
      dialer_(dialer),
      take_(std::move(take)),
      due_(context.scheduler, [this] { release(); }) {}

bool Places::is_unknown(OwnerId kernel) const {
  const auto* host = hosts_.find(kernel);
  const auto* route = routes_.find(kernel);
  const bool says_here = host && !host->hello && host->host_name == context_.options.host_name;
  if (!says_here || links_.is_here(kernel) || (route && route->direct)) return false;
  const auto since = waiting_.find(kernel);
  return since == waiting_.end() || context_.scheduler.now() < since->second + kPlaceTime;
}

void Places::hold(const Package& package) {
  const auto from = package.header.source;
  const bool is_new = !waiting_.contains(from);
  if (is_new) dialer_.prefer_direct(from);
  if (is_new && waiting_.size() >= kMaxPlaceless) return void(++context_.counters.held_requests);
  if (waiting_.emplace(from, context_.scheduler.now()).second) due_.advance_to(context_.scheduler.now() + kPlaceTime);
  const bool is_again = std::any_of(held_.begin(), held_.end(), [&](const Held& one) {
    return one.header.source == from && one.header.ack_id == package.header.ack_id;
  });
  if (is_again) return;
  std::size_t bytes = package.body.size(), of_one = 0;
  for (const auto& one : held_) {
    bytes += one.body.size();
    if (one.header.source == from) ++of_one;
  }
  if (held_.size() >= kMaxHeld || of_one >= kMaxHeldOfOne || bytes > kMaxHeldBytes)
    return void(++context_.counters.held_requests);
  held_.push_back({package.header, Bytes(package.body.begin(), package.body.end())});
}

bool Places::holds_of(OwnerId kernel) const {
  return std::any_of(held_.begin(), held_.end(), [&](const Held& one) { return one.header.source == kernel; });
}

void Places::release() {
  const auto now = context_.scheduler.now();
  std::vector<Held> ready;
  std::erase_if(held_, [&](Held& one) {
    if (is_unknown(one.header.source)) return false;
    ready.push_back(std::move(one));
    return true;
  });
  for (const auto& one : ready) take_({one.header, one.body});
  std::erase_if(waiting_,
                [&](const auto& one) { return now - one.second > kForgetPlace || links_.is_here(one.first); });
  auto next = SteadyTime::max();
  for (const auto& [kernel, since] : waiting_)
    next = std::min(next, now < since + kPlaceTime ? since + kPlaceTime : since + kForgetPlace);
  due_.set_at(next);
}

}  // namespace rubicon::tuples::peis
