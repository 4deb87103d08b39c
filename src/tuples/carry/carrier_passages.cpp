#include <fmt/format.h>

#include "tuples/carry/carrier.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::carry {

namespace {

/// Of components of ours incarnations are times after 1999 (PeerIdentity).
constexpr std::uint64_t kFirstStartOfOurs = 946'684'800'000'000;

}  // namespace

/// Not a stand-in, and no component that is on the owner's engine itself: that one reads the origin.
bool Carrier::serves(const StandInPort& owner, OwnerId reader) const {
  if (reader == self_) return false;
  if (const auto own = stand_ins_.find(reader); own != stand_ins_.end() && own->second->engine == owner.engine)
    return false;
  const auto found = known_.find(reader);
  if (found == known_.end()) return true;  // the own component meets it later
  const auto &here = found->second.at[owner.engine], &there = found->second.at[1 - owner.engine];
  return !there && !(here && is_stand_in(here->identity));
}

Passage& Carrier::passage(StandInPort& owner, OwnerId reader) {
  const PassageKey key{reader, owner.component.id};
  if (const auto found = passages_.find(key); found != passages_.end()) return found->second;
  const auto id = owner.component.id;
  auto& made = passages_.try_emplace(key, id, reader, owner, rules_.keys_of(id)).first->second;
  if (auto* stand_in = find(reader); stand_in && stand_in->engine != owner.engine) made.open(*stand_in);
  if (owner.is_observed && is_kernel(reader)) made.observe();
  return made;
}

bool Carrier::is_kernel(OwnerId reader) const {
  const auto found = known_.find(reader);
  if (found == known_.end()) return false;
  for (const auto& meeting : found->second.at) {
    if (meeting && meeting->identity.incarnation < kFirstStartOfOurs) return true;
  }
  return false;
}

/// What the link itself wants to know comes by the passages of those that it is for.
void Carrier::observe(StandInPort& owner) {
  owner.is_observed = true;
  for (auto& [key, passage] : passages_) {
    if (key.second == owner.component.id && is_kernel(key.first)) passage.observe();
  }
}

/// The own component met it after a stand-in did.
void Carrier::met_reader(OwnerId reader) {
  if (!is_kernel(reader)) return;
  for (auto& [key, passage] : passages_) {
    const auto* owner = key.first == reader ? find(key.second) : nullptr;
    if (owner && owner->is_observed) passage.observe();
  }
}

void Carrier::on_subscribe(OwnerId id, OwnerId subscriber, const SubscriptionSpec& spec) {
  auto* owner = find(id);
  if (!owner) return;
  if (subscriber == kLinkItself) return observe(*owner);
  if ((spec.pattern.owner && *spec.pattern.owner != id) || !serves(*owner, subscriber)) return;
  if (!owner->link().policy().may_subscribe(subscriber, spec)) return;
  if (!passage(*owner, subscriber).subscribe(spec))
    log_.warning(fmt::format("subscriptions {}", number(subscriber)),
                 fmt::format("a subscription of component {} is ignored: too many, or no pattern", number(subscriber)));
  flush_soon({subscriber, id});
  review(subscriber);
}

void Carrier::on_unsubscribe(OwnerId id, OwnerId subscriber, std::uint32_t subscription) {
  const auto found = passages_.find({subscriber, id});
  if (found == passages_.end()) return;
  found->second.unsubscribe(subscription);
  if (!found->second.is_used()) drop_passage(subscriber, id);
}

void Carrier::drop_passage(OwnerId reader, OwnerId owner) {
  auto gone = passages_.extract(PassageKey{reader, owner});
  if (gone.empty()) return;
  gone.mapped().close(true);
  released(reader);
}

void Carrier::drop_passages_of(OwnerId owner) {
  std::vector<OwnerId> readers;
  for (const auto& one : passages_) {
    if (one.first.second == owner) readers.push_back(one.first.first);
  }
  for (const auto reader : readers) drop_passage(reader, owner);
}

/// Its stand-in may have no use any more.
void Carrier::released(OwnerId reader) {
  auto* stand_in = find(reader);
  if (!stand_in) return;
  stand_in->used_until = scheduler_.now() + kLinger;
  review_at(stand_in->used_until, reader);
}

void Carrier::on_changes(OwnerId id, OwnerId owner, std::span<const Change> changes) {
  const auto found = passages_.find({id, owner});
  if (found == passages_.end()) return;
  found->second.on_changes(changes);
  flush_soon(found->first);
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
  if (auto may = owner.link().policy().may_set(set); !may) return may;
  if (!rules_.carries(owner.component.id, set.key)) {
    return fail(ErrorCode::kRefused,
                fmt::format("setting {}: component {} does not carry it from {} to {}", model::quoted(set.key),
                            number(self_), engines_[1 - owner.engine].name, engines_[owner.engine].name));
  }
  if (!serves(owner, set.from)) {
    return fail(ErrorCode::kRefused,
                fmt::format("setting {}: component {} is on {} too, and has to set it there", model::quoted(set.key),
                            number(set.from), engines_[1 - owner.engine].name));
  }
  return {};
}

void Carrier::on_remote_set(OwnerId id, const RemoteSet& set) {
  auto* owner = find(id);
  if (!owner) return;
  auto good = check(*owner, set);
  const auto number = good ? sets_.add(id, set, scheduler_.now(), scheduler_.wall_now()) : 0;
  if (good && number == 0) good = fail(ErrorCode::kBusy, "too many remote sets wait for their replies");
  if (!good) {
    const Reply refusal{set.from, set.request, Verdict::kRefused, good.error().code, std::move(good.error().text)};
    owner->link().policy().answered(set, refusal);
    return owner->link().reply(refusal);
  }
  next_set_.advance_to(sets_.find(number)->due);
  forward(number);
  review(set.from);
}

/// Those of one reader reach an owner in their order: one waits if one before it does.
void Carrier::forward(std::uint64_t number) {
  auto& request = *sets_.find(number);
  auto* reader = find(request.reader);
  if (!reader || !reader->sees(request.owner) || sets_.first_waiting(request.owner, request.reader) != number) return;
  auto& set = *request.waiting;
  if (set.time_to_live > Duration(0))
    set.time_to_live = std::max<Duration>(request.due - scheduler_.now(), Duration(1));
  auto& last = reader->last_requests[request.owner];
  set.request = sets_.wire_number(request, last);
  const auto given = reader->link().remote_set(set);
  if (given) return sets_.sent(request, last = set.request);
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

bool Carrier::on_reply(OwnerId id, OwnerId from, const Reply& reply) {
  const auto asked = sets_.answered(id, reply.request);
  if (asked == 0) return true;
  if (sets_.find(asked)->owner != from) return false;
  const auto request = sets_.take(asked);
  // The asker finds by itself that nothing is known.
  if (reply.verdict != Verdict::kTimedOut) answer(*request, reply);
  released(id);
  return true;
}

void Carrier::answer(const ForwardedSets::Request& request, Reply reply) {
  auto* owner = find(request.owner);
  if (!owner) return;
  reply.to = request.reader;
  reply.request = request.original;
  owner->link().reply(reply);
}

void Carrier::sets_due() {
  for (const auto& request : sets_.take_due(scheduler_.now())) {
    if (request.waiting)
      answer(request, {{}, 0, Verdict::kExpired, ErrorCode::kExpired, "the owner was not reached in time"});
    released(request.reader);
  }
  next_set_.set_at(sets_.next_due());
}

void Carrier::on_met(OwnerId id, OwnerId peer, PeerEvent event) {
  if (event == PeerEvent::kUp) return forward_waiting(peer, id);
  drop_passage(peer, id);
}

}  // namespace rubicon::tuples::carry
