#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/kernel_session.h"
#include "tuples/peis/own_messages.h"
#include "tuples/peis/translation.h"

namespace rubicon::tuples::peis {

/// A kernel ignores UNSUBSCRIBE, and pushes once for each SUBSCRIBE that it got (peis.md, sections 1.7 and 6.3, 23):
/// each pattern is subscribed to once for as long as the kernel is up, and later subscriptions get the copies that are
/// here.
void KernelSession::subscribe(const SubscriptionSpec& spec) {
  auto& subscription = subscriptions_[spec.id];
  forget_patterns(spec.id, subscription.patterns);
  subscription = {spec, {}, true};
  for (const auto& pattern : to_kernel_patterns(spec.pattern.key)) {
    subscription.patterns.push_back(folded(pattern));
    by_pattern_[subscription.patterns.back()].insert(spec.id);
  }
  if (spec.pattern.exact()) spellings_[folded(spec.pattern.key)] = spec.pattern.key;
  for (const auto& pattern : subscription.patterns) request(pattern, true);
  if (!is_acknowledged(subscription)) return;
  later([this, id = spec.id] { settle(id); });
}

void KernelSession::unsubscribe(std::uint32_t id) {
  const auto gone = subscriptions_.extract(id);
  if (gone.empty()) return;
  forget_patterns(id, gone.mapped().patterns);
  if (!gone.mapped().spec.pattern.exact()) return;
  const auto key = folded(gone.mapped().spec.pattern.key);
  if (const auto others = by_pattern_.find(key); others != by_pattern_.end()) {
    for (const auto other : others->second) {
      const auto& pattern = subscriptions_.at(other).spec.pattern;
      if (pattern.exact()) return void(spellings_[key] = pattern.key);
    }
  }
  spellings_.erase(key);
}

void KernelSession::forget_patterns(std::uint32_t id, const std::vector<std::string>& patterns) {
  for (const auto& pattern : patterns) {
    const auto found = by_pattern_.find(pattern);
    if (found == by_pattern_.end()) continue;
    found->second.erase(id);
    if (found->second.empty()) by_pattern_.erase(found);
  }
}

void KernelSession::request(const std::string& pattern, bool force) {
  if (requests_.contains(std::string(kEveryKey)) || requests_.contains(pattern)) return;
  if (requests_.size() >= kMaxRequested) {
    ++context_.counters.refused_patterns;
    context_.log.error("requests to " + name(), fmt::format("more than {} patterns are subscribed to at {}: {} is not",
                                                            kMaxRequested, name(), model::quoted(pattern)));
    return;
  }
  requests_[pattern] = Request::kDue;
  due_requests_[pattern] = force;
  send_due();
}

bool KernelSession::send_next() {
  if (!due_requests_.empty()) {
    const auto next = due_requests_.extract(due_requests_.begin());
    send_request(next.key(), next.mapped());
    return true;
  }
  if (due_tuples_.empty()) return false;
  const auto key = due_tuples_.extract(due_tuples_.begin()).value();
  send(Port::kPush, write_kernel_tuple(context_.self, key, view_.tuples.all().at(key)), watched({}));
  return true;
}

void KernelSession::send_request(const std::string& pattern, bool force) {
  requests_[pattern] = Request::kSent;
  Subscribe out;
  out.force_resend = force;
  out.prototype.owner = peer_;
  out.prototype.key = pattern;
  send(Port::kSubscribe, write(out), guarded([this, pattern](Outcome outcome) { requested(pattern, outcome); }));
}

/// The pushes of the present tuples came before the acknowledgement, by the same route.
void KernelSession::requested(const std::string& pattern, Outcome outcome) {
  const auto found = requests_.find(pattern);
  if (found == requests_.end() || found->second == Request::kDue) return;
  if (outcome != Outcome::kDelivered) {
    found->second = Request::kGivenUp;
    return again_.advance_to(context_.scheduler.now() + kRequestAgain);
  }
  found->second = Request::kAcknowledged;
  std::vector<std::uint32_t> waiting;
  const auto wait = [&](std::uint32_t id) {
    if (subscriptions_.at(id).waits) waiting.push_back(id);
  };
  if (pattern == kEveryKey) {
    for (const auto& [id, subscription] : subscriptions_) wait(id);
  } else if (const auto ids = by_pattern_.find(pattern); ids != by_pattern_.end()) {
    for (const auto id : ids->second) wait(id);
  }
  for (const auto id : waiting) settle(id);
}

void KernelSession::request_again() {
  std::vector<std::string> given_up;
  for (const auto& [pattern, state] : requests_) {
    if (state == Request::kGivenUp) given_up.push_back(pattern);
  }
  for (const auto& pattern : given_up) requests_.erase(pattern);
  for (const auto& pattern : given_up) request(pattern, false);
  if (std::exchange(lost_pushes_, false)) push_again();
}

bool KernelSession::is_acknowledged(const Subscription& subscription) const {
  const auto is_acknowledged = [&](const std::string& pattern) {
    const auto found = requests_.find(pattern);
    return found != requests_.end() && found->second == Request::kAcknowledged;
  };
  return is_acknowledged(std::string(kEveryKey)) ||
         std::all_of(subscription.patterns.begin(), subscription.patterns.end(), is_acknowledged);
}

/// Ends the snapshot of a subscription if the kernel has acknowledged all that it needs.
void KernelSession::settle(std::uint32_t id) {
  const auto found = subscriptions_.find(id);
  if (found == subscriptions_.end() || !is_acknowledged(found->second)) return;
  found->second.waits = false;
  copies_.expire(context_.scheduler.now());
  const auto pattern = found->second.spec.pattern.key;
  copies_.end_round(pattern);
  std::vector<std::string> keys;
  copies_.each(pattern, [&](const KernelCopies::Copy& copy) { keys.push_back(copy.key); });
  for (const auto& key : keys) {
    if (const auto* copy = copies_.find(key)) deliver_copy(*copy);
  }
  deliver(SnapshotEnd{id});
}

/// Kernels send each subscription several times; each time they expect what there is.
void KernelSession::on_subscribe(ByteView body) {
  const auto read = read_subscribe(body);
  if (!read) return bad(read.error());
  const auto& prototype = read->prototype;
  if (prototype.owner && *prototype.owner != context_.self) return;
  // A kernel compares all of these, and finds no tuple: section 6.1, 4.
  const bool never = prototype.write_time || prototype.user_time || prototype.expire_time || prototype.encoding;
  auto added = never ? fail(ErrorCode::kUnsupported, "times or an encoding, which match nothing")
                     : subscribers_.add(*read, context_.scheduler.now());
  // A component of ours whose hello is late: it gets all once more, and subscribes again.
  if (!added && read_subscribe_annex(prototype.annex)) return;
  if (!added) {
    ++context_.counters.refused_patterns;
    context_.log.warning("subscriptions of " + name(), fmt::format("subscription of {} to {}: {}", name(),
                                                                   model::quoted(prototype.key), added.error().text));
    return;
  }
  auto& entry = **added;
  if (!is_folded(entry.pattern) || view_.keys.has_capitals())
    view_.keys.each(entry.pattern, [&](const std::string& key) { subscribers_.add_spelling(entry, key); });
  for (const auto& [key, tuple] : view_.tuples.all()) {
    if (matches_folded(entry.pattern, key)) due_tuples_.insert(key);
  }
  send_due();
  std::vector<std::uint32_t> ids;
  for (const auto& spelling : entry.spellings) ids.push_back(spelling.id);
  for (const auto id : ids) join(id);
}

/// Asks the space for the tuples, also again; one snapshot at a time.
void KernelSession::join(std::uint32_t id) {
  auto* spelling = subscribers_.find(id);
  if (!spelling || !context_.listener || std::exchange(spelling->snapshot_under_way, true)) return;
  context_.listener->on_subscribe(peer_, {id, {context_.self, spelling->pattern}, {}});
}

void KernelSession::key_added(const std::string& key) {
  subscribers_.each_for(key, [&](KernelSubscribers::Entry& entry) {
    if (const auto* added = subscribers_.add_spelling(entry, key)) later([this, id = added->id] { join(id); });
  });
}

void KernelSession::on_unsubscribe(ByteView body) {
  const auto read = read_unsubscribe(body);
  if (!read) return bad(read.error());
  if (read->owner && *read->owner != context_.self) return;
  for (const auto id : subscribers_.remove(*read)) {
    if (context_.listener) context_.listener->on_unsubscribe(peer_, id);
  }
}

}  // namespace rubicon::tuples::peis
