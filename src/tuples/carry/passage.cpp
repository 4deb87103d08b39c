#include "tuples/carry/passage.h"

#include <algorithm>

#include "tuples/carry/carry_rules.h"
#include "tuples/deadlines.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::carry {

namespace {

constexpr std::size_t kMaxFrame = 256;  ///< changes in one call to the link

bool covers(std::string_view wide, std::string_view narrow) {
  return common_keys(wide, narrow) == narrow;
}

std::size_t size_of(const OwnedChange& change) {
  return text_size(change.view());
}

}  // namespace

/// The carried parts of the pattern; no part covers another one.
std::vector<std::string> Passage::carried(std::string_view pattern) const {
  std::vector<std::string> all;
  for (const auto& keys : keys_) {
    auto common = common_keys(keys, pattern);
    if (!common || std::any_of(all.begin(), all.end(), [&](const auto& one) { return covers(one, *common); })) continue;
    std::erase_if(all, [&](const auto& one) { return covers(*common, one); });
    all.push_back(std::move(*common));
  }
  return all;
}

bool Passage::subscribe(const SubscriptionSpec& spec) {
  if (!Pattern::parse(spec.pattern.key)) return false;
  if (subscriptions_.size() >= kMaxSubscriptions && !subscriptions_.contains(spec.id)) return false;
  auto& subscription = subscriptions_[spec.id];
  if (!(subscription.spec.pattern == spec.pattern)) withdraw(subscription);
  let_all_sleep(subscription);
  subscription.spec = spec;
  subscription.keys = carried(spec.pattern.key);
  end_if_empty(subscription);
  send(subscription);
  return true;
}

/// Ends the snapshot of a subscription that has no carried tuple.
void Passage::end_if_empty(const Subscription& subscription) {
  if (subscription.keys.empty() && subscription.spec.id != kObserver) enqueue(SnapshotEnd{subscription.spec.id});
}

void Passage::unsubscribe(std::uint32_t id) {
  const auto found = subscriptions_.find(id);
  if (found == subscriptions_.end()) return;
  withdraw(found->second);
  subscriptions_.erase(found);
}

void Passage::observe() {
  auto& subscription = subscriptions_[kObserver];
  subscription.spec = {kObserver, {owner_, "**"}, {.passive = true}};
  subscription.keys = carried("**");
  send(subscription);
}

void Passage::open(StandInPort& reader) {
  to_owner_ = &reader;
  for (auto& one : subscriptions_) send(one.second);
}

void Passage::close(bool withdraws) {
  for (auto& [id, subscription] : subscriptions_) {
    if (withdraws) withdraw(subscription);
    subscription.woken.clear();
    subscription.wires.clear();
    subscription.awaited.clear();
  }
  of_wire_.clear();
  to_owner_ = nullptr;
}

/// Repeats it, so that the owner sends its snapshot again, if it was sent before.
void Passage::send(Subscription& subscription) {
  if (!to_owner_) return;
  if (subscription.spec.id == kObserver) fresh_.clear();
  if (subscription.wires.empty()) {
    for (const auto& keys : subscription.keys) {
      const auto wire = to_owner_->new_subscription();
      subscription.wires[wire] = keys;
      of_wire_[wire] = subscription.spec.id;
    }
  }
  for (const auto& [wire, keys] : subscription.wires) {
    subscription.awaited.insert(wire);
    to_owner_->link().subscribe({wire, {owner_, keys}, allowed(subscription.spec.flow, keys)});
  }
}

void Passage::withdraw(Subscription& subscription) {
  let_all_sleep(subscription);
  for (const auto& one : subscription.wires) {
    of_wire_.erase(one.first);
    if (to_owner_) to_owner_->link().unsubscribe(one.first);
  }
  subscription.wires.clear();
  subscription.awaited.clear();
}

bool Passage::is_carried(std::string_view key) const {
  return std::any_of(keys_.begin(), keys_.end(), [&](const auto& one) {
    return Pattern{{}, one}.matches(owner_, key);
  });
}

/// Applies the rights of the carrier: the owner judges the carrier, which may see more than the reader.
bool Passage::may_read(std::string_view key) const {
  auto& policy = to_reader_.link().policy();
  return !policy.filters(reader_) || policy.access(reader_, key).read;
}

/// The tuples of a pattern are not known yet. So for a reader with rights to only some of them the subscription is
/// passive, and wake() follows.
Flow Passage::allowed(Flow flow, const std::string& keys) const {
  auto& policy = to_reader_.link().policy();
  if (!policy.filters(reader_)) return flow;
  const bool is_key = keys.find('*') == keys.npos;
  const auto access = is_key ? policy.access(reader_, keys) : Access{true, false, {}};
  flow.passive = flow.passive || !access.demand;
  flow.minimum = std::max(flow.minimum, std::min(access.interval, kMaxDuration));
  return flow;
}

/// A tuple of patterns that are passive because of rights, which the reader may wake: it gets a subscription of its
/// own.
void Passage::wake(std::string_view key) {
  auto& policy = to_reader_.link().policy();
  if (!to_owner_ || !policy.filters(reader_) || !policy.access(reader_, key).demand) return;
  for (auto& [id, subscription] : subscriptions_) {
    const auto& [number, pattern, flow] = subscription.spec;
    const bool is_pattern = id != kObserver && pattern.key.find('*') != pattern.key.npos;
    if (!is_pattern || flow.passive || subscription.woken.contains(key) || !pattern.matches(owner_, key)) continue;
    if (subscription.woken.size() >= kMaxSubscriptions) continue;
    const auto wire = subscription.woken[std::string(key)] = to_owner_->new_subscription();
    to_owner_->link().subscribe({wire, {owner_, std::string(key)}, allowed(flow, std::string(key))});
  }
}

void Passage::let_sleep(Subscription& subscription, std::string_view key) {
  const auto found = subscription.woken.find(key);
  if (found == subscription.woken.end()) return;
  if (to_owner_) to_owner_->link().unsubscribe(found->second);
  subscription.woken.erase(found);
}

void Passage::let_all_sleep(Subscription& subscription) {
  while (!subscription.woken.empty()) let_sleep(subscription, std::string(subscription.woken.begin()->first));
}

void Passage::on_changes(std::span<const Change> changes) {
  for (const auto& change : changes) {
    if (const auto* end = std::get_if<SnapshotEnd>(&change)) {
      end_snapshot(end->subscription);
    } else if (const auto* set = std::get_if<TupleSet>(&change)) {
      on_carried(change, set->tuple.key);
    } else if (const auto* gone = std::get_if<TupleGone>(&change)) {
      on_carried(change, gone->key);
    } else {
      restart(change);
    }
  }
}

/// The reader gets only those observed tuples that it subscribed to.
void Passage::on_carried(const Change& change, std::string_view key) {
  if (!is_carried(key) || !may_read(key)) return;
  if (std::holds_alternative<TupleSet>(change)) {
    wake(key);
  } else {
    for (auto& one : subscriptions_) let_sleep(one.second, key);
  }
  const bool observed = subscriptions_.contains(kObserver);
  if (observed) show_to_link(change, key);
  if (!observed || is_read(key)) enqueue(change);
}

bool Passage::is_read(std::string_view key) const {
  return std::any_of(subscriptions_.begin(), subscriptions_.end(), [&](const auto& one) {
    return one.first != kObserver && one.second.spec.pattern.matches(owner_, key);
  });
}

/// Before the reader gets it: the link numbers tuples by the keys that it knows.
void Passage::show_to_link(const Change& change, std::string_view key) {
  if (std::holds_alternative<TupleSet>(change)) {
    if (!subscriptions_.at(kObserver).awaited.empty()) fresh_.emplace(key);
    to_reader_.observed.emplace(key);
  } else if (const auto known = to_reader_.observed.find(key); known != to_reader_.observed.end()) {
    to_reader_.observed.erase(known);
  }
  to_reader_.link().publish(kLinkItself, {&change, 1});
}

/// A tuple that the link knows and the snapshot lacks was deleted while there was no observer. The link learns that it
/// knows all.
void Passage::end_observed_snapshot() {
  std::erase_if(to_reader_.observed, [&](const std::string& key) {
    if (fresh_.contains(key)) return false;
    const Change gone = TupleGone{EventKind::kDeleted, key, 0};
    to_reader_.link().publish(kLinkItself, {&gone, 1});
    return true;
  });
  fresh_.clear();
  const Change end = SnapshotEnd{};
  to_reader_.link().publish(kLinkItself, {&end, 1});
}

/// What follows replaces what waits, but for snapshots that the owner knows nothing of.
void Passage::restart(const Change& change) {
  std::vector<std::uint32_t> ends;
  for (const auto& waits : waiting_) {
    const auto view = waits.view();
    const auto* end = std::get_if<SnapshotEnd>(&view);
    if (end && subscriptions_.contains(end->subscription) && subscriptions_.at(end->subscription).keys.empty())
      ends.push_back(end->subscription);
  }
  drop_waiting();
  fresh_.clear();
  for (auto& one : subscriptions_) {
    for (const auto& wire : one.second.wires) one.second.awaited.insert(wire.first);
  }
  enqueue(change);
  for (const auto id : ends) enqueue(SnapshotEnd{id});
}

/// A subscription may have several patterns. Its snapshot is complete when the snapshots of all patterns are.
void Passage::end_snapshot(std::uint32_t wire) {
  const auto found = of_wire_.find(wire);
  if (found == of_wire_.end()) return;
  auto& subscription = subscriptions_.at(found->second);
  if (subscription.awaited.erase(wire) == 0 || !subscription.awaited.empty()) return;
  if (found->second == kObserver) return end_observed_snapshot();
  enqueue(SnapshotEnd{found->second});
}

/// The latest value of a key takes the place of one that still waits.
void Passage::enqueue(const Change& change) {
  if (lost_) return;
  OwnedChange copy(change);
  bytes_ += size_of(copy);
  const auto [place, is_new] =
      copy.key().empty() ? std::pair(place_.end(), true) : place_.try_emplace(copy.key(), first_ + waiting_.size());
  if (is_new) {
    waiting_.push_back(std::move(copy));
  } else {
    auto& waits = waiting_[place->second - first_];
    bytes_ -= size_of(waits);
    waits = std::move(copy);
  }
  if (waiting_.size() <= kMaxWaiting && bytes_ <= kMaxWaitingBytes) return;
  drop_waiting();
  lost_ = true;
}

void Passage::drop_waiting() {
  first_ += waiting_.size();
  waiting_.clear();
  place_.clear();
  bytes_ = 0;
}

bool Passage::flush() {
  std::vector<Change> frame;
  while (!waiting_.empty()) {
    frame.clear();
    for (std::size_t at = 0; at < std::min(waiting_.size(), kMaxFrame); ++at) frame.push_back(waiting_[at].view());
    if (!to_reader_.link().publish(reader_, frame)) return false;
    for (std::size_t sent = 0; sent < frame.size(); ++sent, ++first_) {
      const auto& front = waiting_.front();
      bytes_ -= size_of(front);
      if (const auto place = place_.find(front.key()); place != place_.end() && place->second == first_)
        place_.erase(place);
      waiting_.pop_front();
    }
  }
  return !lost_ || ask_again();
}

bool Passage::ask_again() {
  const Change restart = Restart{};
  if (!to_reader_.link().publish(reader_, {&restart, 1})) return false;
  lost_ = false;
  for (auto& [id, subscription] : subscriptions_) {
    end_if_empty(subscription);
    send(subscription);
  }
  return true;
}

}  // namespace rubicon::tuples::carry
