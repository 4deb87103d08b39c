#include "tuples/carry/carrier.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::tuples::carry {

namespace {

/// After a collision, different for two carriers: the one that comes back first is seen by the other.
Duration pause_after(OwnerId carrier, unsigned collisions) {
  const auto mixed = (number(carrier) * 2'654'435'761U) ^ (collisions * 0x9e37'79b9U);
  return Carrier::kSettle + std::chrono::seconds(1 + (mixed >> 13U) % 16);
}

}  // namespace

Carrier::Carrier(OwnerId self, CarryRules rules, std::array<Engine, 2> engines, Scheduler& scheduler,
                 base::LogSink& log)
    : self_(self),
      rules_(std::move(rules)),
      engines_(std::move(engines)),
      scheduler_(scheduler),
      log_(Log(log, "carry"), scheduler),
      taps_{TappedEcology(engines_[0].ecology, 0, self, *this), TappedEcology(engines_[1].ecology, 1, self, *this)} {}

Carrier::~Carrier() = default;

StandInPort* Carrier::find(OwnerId id) {
  const auto found = stand_ins_.find(id);
  return found == stand_ins_.end() ? nullptr : found->second.get();
}

bool Carrier::on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) {
  if (hides(engine, who, event)) return false;
  if (who.id == self_) return true;
  auto& known = known_[who.id];
  known.at[engine].reset();
  if (event == PeerEvent::kUp) known.at[engine] = {who, {}};
  known.changed = scheduler_.now();
  warn_of_carriers(who.id, known);
  if (event == PeerEvent::kUp) met_reader(who.id);
  review(who.id);
  return true;
}

/// Own stand-ins are no news for the own component, which knows their origins.
bool Carrier::hides(std::size_t engine, const PeerIdentity& who, PeerEvent event) {
  auto& hidden = hidden_[engine];
  if (event == PeerEvent::kUp) {
    const auto* own = find(who.id);
    if (!own || own->engine != engine || own->incarnation() != who.incarnation) return false;
    hidden[who.id] = who.incarnation;
    return true;
  }
  const auto found = hidden.find(who.id);
  if (found == hidden.end() || found->second != who.incarnation) return false;
  hidden.erase(found);
  return true;
}

void Carrier::warn_of_carriers(OwnerId id, const Known& known) {
  if (!rules_.carries_any_of(id)) return;
  for (std::size_t engine = 0; engine < known.at.size(); ++engine) {
    const auto& one = known.at[engine];
    const auto carrier = one ? carrier_of(one->identity.host) : model::kNoOwner;
    if (carrier == model::kNoOwner || carrier == self_) continue;
    log_.warning(fmt::format("carrier {}", number(carrier)),
                 fmt::format("component {} carries component {} to {} too: configure one island to carry it",
                             number(carrier), number(id), engines_[engine].name));
  }
}

void Carrier::on_summary(std::size_t engine, OwnerId peer, std::string_view summary) {
  const auto found = known_.find(peer);
  if (found == known_.end() || !found->second.at[engine]) return;
  found->second.at[engine]->summary = summary;
  if (auto* own = find(peer); own && own->engine != engine) own->link().describe(std::string(summary));
}

void Carrier::on_detached(std::size_t engine) {
  hidden_[engine].clear();
  std::vector<OwnerId> all;
  for (auto& [id, known] : known_) {
    known.at[engine].reset();
    known.changed = scheduler_.now();
    all.push_back(id);
  }
  for (const auto id : all) review(id);
}

/// Where the component itself is met, if that is one engine only.
const Carrier::Meeting* Carrier::origin_of(const Known& known) const {
  if (known.at[0].has_value() == known.at[1].has_value()) return nullptr;
  const auto& meeting = known.at[0] ? *known.at[0] : *known.at[1];
  return is_stand_in(meeting.identity) ? nullptr : &meeting;
}

bool Carrier::is_wanted(OwnerId id, const StandInPort* present) const {
  if (rules_.carries_any_of(id) || sets_.has(id)) return true;
  if (present && scheduler_.now() < present->used_until) return true;
  const auto first = passages_.lower_bound({id, OwnerId{}});
  return first != passages_.end() && first->first.first == id;
}

/// Begins or ends the stand-in of a component, as things are now.
void Carrier::review(OwnerId id) {
  const auto found = known_.find(id);
  if (found == known_.end()) return;
  const auto& known = found->second;
  const auto* origin = origin_of(known);
  const auto* present = find(id);
  const bool is_of_it =
      present && origin && present->component.incarnation == origin->identity.incarnation && !known.at[present->engine];
  if (present && (!is_of_it || !is_wanted(id, present))) {
    end(id);
    present = nullptr;
  }
  if (!known.at[0] && !known.at[1]) return void(known_.erase(found));
  if (present && present->used_until > scheduler_.now()) review_at(present->used_until, id);
  if (!origin || present || !is_wanted(id, nullptr)) return;
  const auto ready = std::max(known.changed + kSettle, known.held);
  if (ready > scheduler_.now()) return review_at(ready, id);
  begin(id, known.at[0] ? 0 : 1);
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

void Carrier::begin(OwnerId id, std::size_t origin) {
  if (stand_ins_.size() >= rules_.most) return refuse_excess(id);
  const auto& meeting = *known_.at(id).at[origin];
  const auto to = 1 - origin;
  last_incarnation_ =
      std::max(static_cast<std::uint64_t>(scheduler_.wall_now().time_since_epoch().count()) + number(self_) % 65'536,
               last_incarnation_ + 1);
  const auto incarnation = last_incarnation_;
  const auto displaced = lifetime_.guard([this, id, incarnation] { this->displaced(id, incarnation); });
  auto link = engines_[to].ecology.join_as({id, marked_host(meeting.identity.host, self_), displaced});
  if (!link) {
    log_.warning(fmt::format("stand-in {}", number(id)),
                 fmt::format("component {} of {} is not carried to {}: {}", number(id), engines_[origin].name,
                             engines_[to].name, link.error().text));
    known_.at(id).held = scheduler_.now() + kLinger;
    return review_at(known_.at(id).held, id);
  }
  log_.debug(fmt::format("begin {}", number(id)), fmt::format("component {} of {} has a stand-in on {}", number(id),
                                                              engines_[origin].name, engines_[to].name));
  StandInEvents& events = *this;
  const auto port = std::make_shared<StandInPort>(meeting.identity, to, std::move(*link), events);
  stand_ins_[id] = port;
  port->link().describe(meeting.summary);
  port->begin(incarnation);
  for (auto& [key, passage] : passages_) {
    if (key.first == id) passage.open(*port);
  }
}

void Carrier::refuse_excess(OwnerId id) {
  excess_.insert(id);
  if (std::exchange(excess_logged_, true)) return;
  log_.unlimited().error(
      fmt::format("{} components have stand-ins, which is the most: component {} and others after it are not carried",
                  stand_ins_.size(), number(id)));
}

/// The link is destroyed in a later turn, because a call of it may be under way, and before its engine at the latest.
void Carrier::end(OwnerId id) {
  auto gone = stand_ins_.extract(id);
  if (gone.empty()) return;
  drop_passages_of(id);
  for (auto& [key, passage] : passages_) {
    if (key.first == id) passage.close(false);
  }
  sets_.forget(id);
  gone.mapped()->end();
  ended_.push_back(std::move(gone.mapped()));
  lifetime_.post(scheduler_, [this] { ended_.clear(); });
  for (const auto waiting : std::exchange(excess_, {})) review_at(scheduler_.now(), waiting);
}

/// Another presence uses the id on the engine of the stand-in: the component itself, or the stand-in of another
/// carrier.
void Carrier::displaced(OwnerId id, std::uint64_t incarnation) {
  const auto* present = find(id);
  if (!present || present->incarnation() != incarnation) return;
  const auto engine = present->engine;
  log_.warning(fmt::format("displaced {}", number(id)),
               fmt::format("component {} is met on {} by another way too: it is not carried there for now", number(id),
                           engines_[engine].name));
  end(id);
  auto& known = known_[id];
  known.held = scheduler_.now() + pause_after(self_, ++known.collisions);
  review(id);
}

}  // namespace rubicon::tuples::carry
