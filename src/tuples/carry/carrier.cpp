#include "tuples/carry/carrier.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::tuples::carry {

namespace {

/// Pause after a collision. It differs between carriers, so that one comes back first and the other sees it.
Duration pause_after(OwnerId carrier, unsigned collisions) {
  const auto mixed = (number(carrier) * 2'654'435'761U) ^ (collisions * 0x9e37'79b9U);
  return Carrier::kSettle + std::chrono::seconds(1 + (mixed >> 13U) % 16);
}

}  // namespace

Carrier::Carrier(OwnerId self, CarryRules rules, std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log)
    : self_(self),
      rules_(std::move(rules)),
      engines_(std::move(engines)),
      scheduler_(scheduler),
      log_(Log(log, "carry"), scheduler),
      hidden_(engines_.size()) {
  TapEvents& events = *this;
  for (std::size_t one = 0; one < engines_.size(); ++one) {
    taps_.emplace_back(engines_[one].ecology, one, self, events);
    for (std::size_t other = 0; other < one; ++other) {
      const auto &name = engines_[one].name, &before = engines_[other].name;
      if (auto digest = rules_.digest(before, name); !digest.empty())
        carries_.emplace(pair_name(before, name), std::move(digest));
    }
  }
}

Carrier::~Carrier() = default;

StandInPort* Carrier::find(OwnerId id, std::size_t engine) const {
  const auto found = stand_ins_.find({id, engine});
  return found == stand_ins_.end() ? nullptr : found->second.get();
}

Way Carrier::way_to(const StandInPort& stand_in) const {
  return {engines_[stand_in.origin].name, engines_[stand_in.engine].name};
}

std::string Carrier::shown(std::string summary) const {
  return with_announcement(std::move(summary), carries_);
}

bool Carrier::on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) {
  if (hides(engine, who, event)) return false;
  if (who.id == self_) return true;
  auto& known = known_[who.id];
  known.at.resize(engines_.size());
  known.at[engine].meeting.reset();
  if (event == PeerEvent::kUp) known.at[engine].meeting = {who, {}};
  known.changed = scheduler_.now();
  review_carrier(who.id);
  if (event == PeerEvent::kUp) met_reader(who.id);
  review(who.id);
  return true;
}

/// Own stand-ins are no news for the own component, which knows their origins.
bool Carrier::hides(std::size_t engine, const PeerIdentity& who, PeerEvent event) {
  auto& hidden = hidden_[engine];
  if (event == PeerEvent::kUp) {
    const auto* own = find(who.id, engine);
    if (!own || own->incarnation() != who.incarnation) return false;
    hidden[who.id] = who.incarnation;
    return true;
  }
  const auto found = hidden.find(who.id);
  if (found == hidden.end() || found->second != who.incarnation) return false;
  hidden.erase(found);
  return true;
}

void Carrier::on_summary(std::size_t engine, OwnerId peer, std::string_view summary) {
  const auto found = known_.find(peer);
  if (found == known_.end() || !found->second.at[engine].meeting) return;
  found->second.at[engine].meeting->summary = summary;
  review_carrier(peer);
  for (auto one = stand_ins_.lower_bound({peer, 0}); one != stand_ins_.end() && one->first.first == peer; ++one) {
    if (one->second->origin == engine) one->second->link().describe(std::string(summary));
  }
}

void Carrier::on_detached(std::size_t engine) {
  hidden_[engine].clear();
  std::vector<OwnerId> all;
  for (auto& [id, known] : known_) {
    known.at[engine].meeting.reset();
    known.changed = scheduler_.now();
    all.push_back(id);
  }
  for (const auto id : all) review_carrier(id);
  for (const auto id : all) review(id);
}

/// The component itself, not a stand-in.
bool Carrier::is_met(const Known& known, std::size_t engine) const {
  const auto& meeting = known.at[engine].meeting;
  return meeting && !is_stand_in(meeting->identity);
}

/// Where the component is met that needs a stand-in on that engine; nullopt: it needs none.
std::optional<std::size_t> Carrier::origin_of(OwnerId id, const Known& known, std::size_t to) const {
  if (known.at[to].meeting) return {};
  for (std::size_t from = 0; from < engines_.size(); ++from) {
    if (is_met(known, from) && is_wanted(id, from, to)) return from;
  }
  return {};
}

/// A reader of what is carried here needs its stand-in here, too.
bool Carrier::is_wanted(OwnerId id, std::size_t origin, std::size_t to) const {
  const bool carries = rules_.carries_any_of(id, {engines_[origin].name, engines_[to].name});
  if ((carries && !gives_way(id, origin, to)) || sets_.has(id, to)) return true;
  for (auto one = passages_.lower_bound({id, OwnerId{}, 0}); one != passages_.end(); ++one) {
    if (std::get<0>(one->first) != id) return false;
    if (one->second.origin() == to) return true;
  }
  return false;
}

/// Whether it may stay.
bool Carrier::is_good(const StandInPort& present, const Known& known) const {
  const auto& component = present.component;
  if (known.at[present.engine].meeting || !is_met(known, present.origin)) return false;
  if (known.at[present.origin].meeting->identity.incarnation != component.incarnation) return false;
  if (is_wanted(component.id, present.origin, present.engine)) return true;
  return scheduler_.now() < present.used_until && !gives_way(component.id, present.origin, present.engine);
}

/// Begins and ends the stand-ins of a component, as things are now.
void Carrier::review(OwnerId id) {
  if (!known_.contains(id)) return;
  for (std::size_t to = 0; to < engines_.size(); ++to) review(id, to);
  const auto& known = known_.at(id);
  warn_of_carriers(id, known);
  const auto is_nowhere = [](const Known::At& one) { return !one.meeting; };
  if (!std::all_of(known.at.begin(), known.at.end(), is_nowhere)) return;
  known_.erase(id);
  excess_.erase(id);
}

void Carrier::review(OwnerId id, std::size_t to) {
  const auto& known = known_.at(id);
  if (const auto* present = find(id, to)) {
    if (is_good(*present, known)) {
      if (present->used_until > scheduler_.now()) review_at(present->used_until, id);
      return;
    }
    end(id, to);
  }
  const auto origin = origin_of(id, known, to);
  if (!origin) return;
  const auto ready = std::max(known.changed + kSettle, known.at[to].held);
  if (ready > scheduler_.now()) return review_at(ready, id);
  begin(id, *origin, to);
}

void Carrier::review_at(SteadyTime when, OwnerId id) {
  auto& due = reviews_.try_emplace(id, when).first->second;
  due = std::min(due, when);
  next_review_.advance_to(when);
}

void Carrier::review_due() {
  std::vector<OwnerId> due;
  for (const auto& [id, when] : reviews_) {
    if (when <= scheduler_.now() && due.size() < kStartsPerTurn) due.push_back(id);
  }
  for (const auto id : due) reviews_.erase(id);
  for (const auto id : due) review(id);
  for (const auto& [id, when] : reviews_) next_review_.advance_to(std::max(when, scheduler_.now() + kRetry));
}

std::uint64_t Carrier::new_incarnation() {
  const auto now = static_cast<std::uint64_t>(scheduler_.wall_now().time_since_epoch().count());
  return last_incarnation_ = std::max(now + number(self_) % 65'536, last_incarnation_ + 1);
}

void Carrier::begin(OwnerId id, std::size_t origin, std::size_t to) {
  if (stand_ins_.size() >= rules_.most) return refuse_excess(id);
  auto& known = known_.at(id);
  const auto& meeting = *known.at[origin].meeting;
  const auto incarnation = new_incarnation();
  const auto displaced = lifetime_.guard([this, id, to, incarnation] { this->displaced(id, to, incarnation); });
  auto link = engines_[to].ecology.join_as({id, marked_host(meeting.identity.host, self_), displaced});
  if (!link) {
    // A component of this process is on all engines; it is met there as soon as they have a connection.
    if (link.error().code != ErrorCode::kDuplicate)
      log_.warning(fmt::format("stand-in {}", number(id)),
                   fmt::format("component {} of {} is not carried to {}: {}", number(id), engines_[origin].name,
                               engines_[to].name, link.error().text));
    known.at[to].held = scheduler_.now() + kLinger;
    return review_at(known.at[to].held, id);
  }
  log_.debug(fmt::format("begin {}", number(id)), fmt::format("component {} of {} has a stand-in on {}", number(id),
                                                              engines_[origin].name, engines_[to].name));
  StandInEvents& events = *this;
  const auto port = std::make_shared<StandInPort>(meeting.identity, origin, to, std::move(*link), events);
  stand_ins_[{id, to}] = port;
  port->link().describe(meeting.summary);
  port->begin(incarnation);
  for (auto& [key, passage] : passages_) {
    if (std::get<0>(key) == id && passage.origin() == to) passage.open(*port);
  }
}

void Carrier::refuse_excess(OwnerId id) {
  excess_.insert(id);
  if (std::exchange(excess_logged_, true)) return;
  log_.unlimited().error(
      fmt::format("there are {} stand-ins, which is the most: component {} and others after it are not carried",
                  stand_ins_.size(), number(id)));
}

/// The link is destroyed in a later turn, because a call of it may be under way, and before its engine at the latest.
void Carrier::end(OwnerId id, std::size_t engine) {
  auto gone = stand_ins_.extract({id, engine});
  if (gone.empty()) return;
  drop_passages_of(id, engine);
  for (auto& [key, passage] : passages_) {
    if (std::get<0>(key) == id && passage.origin() == engine) passage.close(false);
  }
  sets_.forget(id, engine);
  gone.mapped()->end();
  ended_.push_back(std::move(gone.mapped()));
  lifetime_.post(scheduler_, [this] { ended_.clear(); });
  for (const auto waiting : std::exchange(excess_, {})) review_at(scheduler_.now(), waiting);
}

/// Another presence uses the id on the engine of the stand-in: the component itself, or the stand-in of another
/// carrier.
void Carrier::displaced(OwnerId id, std::size_t engine, std::uint64_t incarnation) {
  const auto* present = find(id, engine);
  if (!present || present->incarnation() != incarnation) return;
  log_.warning(fmt::format("displaced {}", number(id)),
               fmt::format("component {} is met on {} by another way too: it is not carried there for now", number(id),
                           engines_[engine].name));
  end(id, engine);
  auto& known = known_[id];
  known.at.resize(engines_.size());
  auto& here = known.at[engine];
  here.held = scheduler_.now() + pause_after(self_, ++here.collisions);
  review(id);
}

/// Whether that component carries the same between engines where it is met itself.
void Carrier::review_carrier(OwnerId id) {
  Pairs pairs;
  const auto found = known_.find(id);
  for (std::size_t other = 0; found != known_.end() && other < engines_.size(); ++other) {
    if (!is_met(found->second, other)) continue;
    const auto announced = announcement_of(found->second.at[other].meeting->summary);
    for (std::size_t one = 0; one < other && !announced.empty(); ++one) {
      const auto pair = pair_name(engines_[one].name, engines_[other].name);
      const auto theirs = announced.find(pair);
      const auto ours = carries_.find(pair);
      if (!is_met(found->second, one) || theirs == announced.end() || ours == carries_.end()) continue;
      if (theirs->second == ours->second) pairs.emplace(one, other);
    }
  }
  const auto known = others_.find(id);
  if (known == others_.end() ? pairs.empty() : known->second == pairs) return;
  others_.erase(id);
  for (const auto& [one, other] : pairs) {
    log_.unlimited().info(fmt::format("component {} carries the same between {} and {}: {} does", number(id),
                                      engines_[one].name, engines_[other].name,
                                      number(id) < number(self_) ? "it" : "this island"));
  }
  if (!pairs.empty()) others_.emplace(id, std::move(pairs));
  for (const auto& one : known_) review_at(scheduler_.now(), one.first);
}

/// Between the same two engines the carrier with the lowest id carries, of those whose stand-in others believe.
bool Carrier::gives_way(OwnerId id, std::size_t origin, std::size_t to) const {
  for (const auto& [other, pairs] : others_) {
    if (number(other) > number(self_)) return false;
    if (pairs.contains(std::minmax(origin, to)) && engines_[to].ecology.may_stand_in(other, id)) return true;
  }
  return false;
}

/// Carriers with other rules, and earlier releases, do not know of each other: the first one carries.
void Carrier::warn_of_carriers(OwnerId id, const Known& known) {
  for (std::size_t to = 0; to < known.at.size(); ++to) {
    const auto& meeting = known.at[to].meeting;
    const auto carrier = meeting ? carrier_of(meeting->identity.host) : model::kNoOwner;
    const auto other = known_.find(carrier);
    if (carrier == self_ || other == known_.end() || others_.contains(carrier)) continue;
    for (std::size_t from = 0; from < known.at.size(); ++from) {
      if (!is_met(other->second, from) || !is_met(other->second, to)) continue;
      if (!is_met(known, from) || !rules_.carries_any_of(id, {engines_[from].name, engines_[to].name})) continue;
      if (const auto ready = known.changed + kSettle; ready > scheduler_.now()) return review_at(ready, id);
      log_.warning(fmt::format("carrier {}", number(carrier)),
                   fmt::format("component {} carries component {} to {} too, with other rules: give both the same, or "
                               "configure one island to carry it",
                               number(carrier), number(id), engines_[to].name));
    }
  }
}

}  // namespace rubicon::tuples::carry
