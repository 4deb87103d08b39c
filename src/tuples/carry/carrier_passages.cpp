#include <fmt/format.h>

#include <algorithm>

#include "tuples/carry/carrier.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::carry {

namespace {

/// The incarnation of a component of ours is a time after 1999 (PeerIdentity).
constexpr std::uint64_t kFirstStartOfOurs = 946'684'800'000'000;

/// The owner would judge it as a message of this carrier.
bool is_message(std::string_view key) {
  const auto first = key.substr(0, key.find('.'));
  return first == "GATEWAY" || first == "RUBICON_GATEWAY";
}

}  // namespace

/// Not a stand-in, and no component that is on an engine of the owner itself: that one reads the origin.
bool Carrier::serves(const StandInPort& owner, OwnerId reader) const {
  if (reader == self_ || find(reader, owner.engine)) return false;
  const auto found = known_.find(reader), origin = known_.find(owner.component.id);
  if (found == known_.end() || origin == known_.end()) return true;  // the own component meets it later
  for (std::size_t engine = 0; engine < engines_.size(); ++engine) {
    if (is_met(found->second, engine) && is_met(origin->second, engine)) return false;
  }
  return !found->second.at[owner.engine].meeting || is_met(found->second, owner.engine);
}

Passage& Carrier::passage(StandInPort& owner, OwnerId reader) {
  const auto id = owner.component.id;
  const PassageKey key{reader, id, owner.engine};
  if (const auto found = passages_.find(key); found != passages_.end()) return found->second;
  auto& made = passages_.try_emplace(key, id, reader, owner, rules_.keys_of(id, way_to(owner))).first->second;
  if (auto* stand_in = find(reader, owner.origin)) made.open(*stand_in);
  if (owner.is_observed && is_kernel(reader)) made.observe();
  return made;
}

bool Carrier::is_kernel(OwnerId reader) const {
  const auto found = known_.find(reader);
  if (found == known_.end()) return false;
  const auto& all = found->second.at;
  return std::any_of(all.begin(), all.end(), [](const Known::At& one) {
    return one.meeting && one.meeting->identity.incarnation < kFirstStartOfOurs;
  });
}

/// What the link itself subscribes to comes by the passages of the components that it serves.
void Carrier::observe(StandInPort& owner) {
  owner.is_observed = true;
  for (auto& [key, passage] : passages_) {
    if (std::get<1>(key) == owner.component.id && std::get<2>(key) == owner.engine && is_kernel(std::get<0>(key)))
      passage.observe();
  }
}

/// The own component met it after a stand-in did.
void Carrier::met_reader(OwnerId reader) {
  if (!is_kernel(reader)) return;
  for (auto& [key, passage] : passages_) {
    const auto* owner = std::get<0>(key) == reader ? find(std::get<1>(key), std::get<2>(key)) : nullptr;
    if (owner && owner->is_observed) passage.observe();
  }
}

void Carrier::on_subscribe(StandInPort& owner, OwnerId subscriber, const SubscriptionSpec& spec) {
  if (subscriber == kLinkItself) return observe(owner);
  const auto id = owner.component.id;
  if ((spec.pattern.owner && *spec.pattern.owner != id) || !serves(owner, subscriber)) return;
  if (!owner.link().policy().may_subscribe(subscriber, spec)) return;
  if (!passage(owner, subscriber).subscribe(spec))
    log_.warning(fmt::format("subscriptions {}", number(subscriber)),
                 fmt::format("a subscription of component {} is ignored: too many, or no pattern", number(subscriber)));
  flush_soon({subscriber, id, owner.engine});
  review(subscriber);
}

void Carrier::on_unsubscribe(const StandInPort& owner, OwnerId subscriber, std::uint32_t subscription) {
  const PassageKey key{subscriber, owner.component.id, owner.engine};
  const auto found = passages_.find(key);
  if (found == passages_.end()) return;
  found->second.unsubscribe(subscription);
  if (!found->second.is_used()) drop_passage(key);
}

void Carrier::drop_passage(const PassageKey& key) {
  auto gone = passages_.extract(key);
  if (gone.empty()) return;
  gone.mapped().close(true);
  released(std::get<0>(key), gone.mapped().origin());
  review_at(scheduler_.now(), std::get<0>(key));
}

void Carrier::drop_passages_of(OwnerId owner, std::size_t engine) {
  std::vector<PassageKey> keys;
  for (const auto& one : passages_) {
    if (std::get<1>(one.first) == owner && std::get<2>(one.first) == engine) keys.push_back(one.first);
  }
  for (const auto& key : keys) drop_passage(key);
}

/// Its stand-in there may not be needed any more.
void Carrier::released(OwnerId reader, std::size_t engine) {
  auto* stand_in = find(reader, engine);
  if (!stand_in) return;
  stand_in->used_until = scheduler_.now() + kLinger;
  review_at(stand_in->used_until, reader);
}

void Carrier::on_changes(const StandInPort& reader, OwnerId owner, std::span<const Change> changes) {
  const auto id = reader.component.id;
  for (auto one = passages_.lower_bound({id, owner, 0}); one != passages_.end(); ++one) {
    const auto& [key, passage] = *one;
    if (std::get<0>(key) != id || std::get<1>(key) != owner) return;
    if (passage.origin() != reader.engine) continue;
    one->second.on_changes(changes);
    flush_soon(key);
  }
}

void Carrier::flush_soon(const PassageKey& passage) {
  unsent_.insert(passage);
  flush_soon_.request();
}

void Carrier::flush() {
  std::erase_if(unsent_, [this](const PassageKey& key) {
    const auto found = passages_.find(key);
    return found == passages_.end() || found->second.flush();
  });
  if (!unsent_.empty()) retry_.advance_to(scheduler_.now() + kRetry);
}

Result<void> Carrier::check(StandInPort& owner, const RemoteSet& set) const {
  auto& policy = owner.link().policy();
  if (auto may = policy.may_set(set); !may) return may;
  if (policy.judge() && is_message(set.key))
    return fail(ErrorCode::kRefused,
                fmt::format("component {} has rights, and carries no messages: send them to it", number(self_)));
  const auto way = way_to(owner);
  if (!rules_.carries(owner.component.id, set.key, way)) {
    return fail(ErrorCode::kRefused, fmt::format("setting {}: component {} does not carry it from {} to {}",
                                                 model::quoted(set.key), number(self_), way.from, way.to));
  }
  if (!serves(owner, set.from)) {
    return fail(ErrorCode::kRefused, fmt::format("setting {}: component {} is on {} too, and has to set it there",
                                                 model::quoted(set.key), number(set.from), way.from));
  }
  return {};
}

/// The host as its own engine knows it; empty: not known.
std::string Carrier::asker(StandInPort& owner, const RemoteSet& set) const {
  if (const auto* judged = owner.link().policy().asker(set)) return judged->name_with_source();
  const auto found = known_.find(set.from);
  const auto& meeting = found == known_.end() ? std::nullopt : found->second.at[owner.engine].meeting;
  const auto& member = meeting ? meeting->identity.member : nullptr;
  return member ? member->name_with_source() : std::string();
}

void Carrier::on_remote_set(StandInPort& owner, const RemoteSet& asked) {
  auto set = asked;
  auto good = check(owner, set);
  set.asker = asker(owner, asked);
  const auto number =
      good ? sets_.add(owner.component.id, owner.engine, owner.origin, set, scheduler_.now(), scheduler_.wall_now())
           : 0;
  if (good && number == 0) good = fail(ErrorCode::kBusy, "too many remote sets wait for their replies");
  if (!good) {
    const Reply refusal{set.from, set.request, Verdict::kRefused, good.error().code, std::move(good.error().text)};
    owner.link().policy().answered(set, refusal);
    return owner.link().reply(refusal);
  }
  next_set_.advance_to(sets_.find(number)->due);
  forward(number);
  review(set.from);
}

/// The sets of one reader reach an owner in their order: a set waits if an earlier one waits.
void Carrier::forward(std::uint64_t number) {
  auto& request = *sets_.find(number);
  auto* reader = find(request.reader, request.goes);
  if (!reader || !reader->sees(request.owner) || sets_.first_waiting(request.owner, request.reader) != number) return;
  auto& set = *request.waiting;
  if (set.time_to_live > Duration(0))
    set.time_to_live = std::max<Duration>(request.due - scheduler_.now(), Duration(1));
  set.request = sets_.wire_number(request, reader->last_request(request.owner));
  const auto given = reader->link().remote_set(set);
  if (given) {
    reader->requested(request.owner, set.request);
    return sets_.sent(request, set.request);
  }
  if (given.error().code == ErrorCode::kNotFound) return;
  const auto verdict = Verdict::kRefused;
  answer(*sets_.take(number), {{}, 0, verdict, given.error().code, given.error().text});
}

void Carrier::forward_waiting(OwnerId owner, OwnerId reader) {
  while (const auto number = sets_.first_waiting(owner, reader)) {
    forward(number);
    if (sets_.first_waiting(owner, reader) == number) return;
  }
}

bool Carrier::on_reply(const StandInPort& reader, OwnerId from, const Reply& reply) {
  const auto asked = sets_.answered(reader.component.id, reader.engine, reply.request);
  if (asked == 0) return true;
  if (sets_.find(asked)->owner != from) return false;
  const auto request = sets_.take(asked);
  // The asker finds by itself that nothing is known.
  if (reply.verdict != Verdict::kTimedOut) answer(*request, reply);
  released(reader.component.id, reader.engine);
  return true;
}

void Carrier::answer(const ForwardedSets::Request& request, Reply reply) {
  auto* owner = find(request.owner, request.asked);
  if (!owner) return;
  reply.to = request.reader;
  reply.request = request.original;
  owner->link().reply(reply);
}

void Carrier::sets_due() {
  for (const auto& request : sets_.take_due(scheduler_.now())) {
    if (request.waiting)
      answer(request, {{}, 0, Verdict::kExpired, ErrorCode::kExpired, "the owner was not reached in time"});
    released(request.reader, request.goes);
  }
  next_set_.set_at(sets_.next_due());
}

void Carrier::on_met(const StandInPort& by, OwnerId peer, PeerEvent event) {
  if (event == PeerEvent::kUp) return forward_waiting(peer, by.component.id);
  drop_passage({peer, by.component.id, by.engine});
}

}  // namespace rubicon::tuples::carry
