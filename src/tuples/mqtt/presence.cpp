#include "tuples/mqtt/presence.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "tuples/link.h"

namespace rubicon::tuples::mqtt {

namespace {

/// Bytes of a connection, and of a component with what links keep of it.
constexpr std::size_t kShownOverhead = 256, kComponentOverhead = 2048;

std::size_t size_of(const Reached& one) {
  return kComponentOverhead + 2 * one.line.user.size() + one.shown.host.size() + one.shown.summary.size();
}

bool is_same(const Reached& one, const Reached& other) {
  return one.line.user == other.line.user && one.shown.incarnation == other.shown.incarnation &&
         one.shown.host == other.shown.host;
}

bool is_stand_in(const Reached& one) {
  return carrier_of(one.shown.host) != model::kNoOwner;
}

}  // namespace

Presence::Presence(Scheduler& scheduler, Callbacks calls)
    : scheduler_(scheduler), callbacks_(std::move(calls)), expiry_(scheduler, [this] { expire(); }) {}

/// False: no room.
bool Presence::add_bytes(const std::string& user, std::size_t more, std::size_t less) {
  auto& of_user = bytes_of_[user];
  const bool fits = bytes_ - less + more <= kMaxBytes && of_user - less + more <= kMaxUserBytes;
  if (fits || more == 0) {
    bytes_ += more - less;
    of_user += more - less;
  }
  if (of_user == 0) bytes_of_.erase(user);
  return fits;
}

bool Presence::show(const Line& line, const LineShown& shown) {
  if (!lines_.contains(line) && !add_bytes(line.user, kShownOverhead, 0)) return false;
  auto& state = lines_[line];
  state.shown = shown;
  state.until = SteadyTime::max();
  state.here = state.seen = true;
  for (const auto id : shown_on(line)) review(id, PeerEvent::kLost);
  return true;
}

void Presence::show_here(const Line& line, Duration lease, const std::map<OwnerId, ComponentShown>& components) {
  const auto before = here_;
  if (before.token.empty() || before.user != line.user) here_ = line;
  if (!has(here_)) std::ignore = show(here_, {std::numeric_limits<std::uint64_t>::max(), lease});
  for (const auto& [id, shown] : components) std::ignore = show(here_, id, shown);
  for (const auto id : shown_on(before)) {
    if (before != here_ || !components.contains(id)) leave(before, id);
  }
  if (before != here_) hide(before);
}

/// The topics of an earlier connection may be emptied before those of its successor are read. So end_reading() decides
/// about topics that were not seen.
void Presence::hide(const Line& line) {
  const auto found = lines_.find(line);
  if (found == lines_.end() || !found->second.here || !found->second.seen) return;
  found->second.here = false;
  end_at(found->second.until, scheduler_.now() + kReturn);
}

void Presence::end_at(SteadyTime& until, SteadyTime when) {
  until = std::min(until, when);
  expiry_.advance_to(until);
}

bool Presence::show(const Line& line, OwnerId id, ComponentShown shown) {
  const auto as = std::make_shared<const Reached>(Reached{line, std::move(shown)});
  const auto* known = find(line, id);
  const bool is_new = !lines_.contains(line);
  if (!add_bytes(line.user, size_of(*as) + (is_new ? kShownOverhead : 0), known ? size_of(*known->as) : 0))
    return false;
  components_[id].insert_or_assign(line, Component{as});
  auto& state = lines_[line];
  if (is_new) {  // its own topic may follow
    end_at(state.until, scheduler_.now() + kReturn);
    state.seen = true;
  }
  state.ids.insert(id);
  review(id, PeerEvent::kLost);
  return true;
}

void Presence::fade(const Line& line, OwnerId id) {
  auto* one = find(line, id);
  if (one && lines_.at(line).seen) end_at(one->until, scheduler_.now() + kReturn);
}

void Presence::remove(const Line& line, OwnerId id, PeerEvent how) {
  const auto* one = find(line, id);
  if (!one) return;
  add_bytes(line.user, 0, size_of(*one->as));
  const auto all = components_.find(id);
  all->second.erase(line);
  if (all->second.empty()) components_.erase(all);
  if (const auto state = lines_.find(line); state != lines_.end()) state->second.ids.erase(id);
  review(id, how);
}

void Presence::begin_reading() {
  for (auto& [line, state] : lines_) state.seen = is_here(line);
  for (auto& [id, all] : components_) {
    for (auto& [line, one] : all) one.seen = is_here(line);
  }
}

void Presence::cut() {
  begin_reading();
  for (auto& [line, state] : lines_) {
    if (state.here && !is_here(line)) end_at(state.until, scheduler_.now() + state.shown.lease);
  }
}

void Presence::await(const Line& line) {
  const auto found = lines_.find(line);
  if (found != lines_.end() && !found->second.here) found->second.until = SteadyTime::max();
}

void Presence::end_reading(const Line& line) {
  const auto found = lines_.find(line);
  if (found != lines_.end() && !found->second.here) end_at(found->second.until, scheduler_.now() + kReturn);
}

void Presence::end_reading(bool all) {
  const auto now = scheduler_.now();
  for (auto& [line, state] : lines_) {
    if (all && !state.here) end_at(state.until, now + kReturn);
    if (state.seen || !std::exchange(state.here, false)) continue;
    state.until = now + std::max(state.shown.lease, kReturn);
    expiry_.advance_to(state.until);
  }
  for (auto& [id, shown] : components_) {
    for (auto& [line, one] : shown) {
      if (!one.seen && lines_.at(line).seen) end_at(one.until, now + kReturn);
    }
  }
}

void Presence::doubt(const Line& line, OwnerId id, bool doubted) {
  auto* one = find(line, id);
  if (!one) return;
  one->answered = !doubted;
  if (std::exchange(one->doubted, doubted) != doubted) review(id, PeerEvent::kLost);
}

bool Presence::is_rival(OwnerId id, const Component& one, const Reached& reached) const {
  return one.as->line.user == reached.line.user && !is_same(*one.as, reached) && !is_stand_in(*one.as) &&
         counts(id, one) && lines_.at(one.as->line).here;
}

std::vector<OwnerId> Presence::contested() const {
  std::vector<OwnerId> found;
  for (const auto& [id, reached] : reached_) {
    const auto& all = components_.at(id);
    const auto rivals = [&, id = id, by = reached](const auto& one) { return is_rival(id, one.second, *by); };
    if (!all.at(reached->line).answered && std::any_of(all.begin(), all.end(), rivals)) found.push_back(id);
  }
  return found;
}

std::vector<std::pair<OwnerId, Presence::Shown>> Presence::doubted() const {
  std::vector<std::pair<OwnerId, Shown>> found;
  for (const auto& [id, all] : components_) {
    for (const auto& [line, one] : all) {
      if (one.doubted) found.emplace_back(id, one.as);
    }
  }
  return found;
}

Presence::Component* Presence::find(const Line& line, OwnerId id) {
  const auto found = components_.find(id);
  if (found == components_.end()) return nullptr;
  const auto one = found->second.find(line);
  return one == found->second.end() ? nullptr : &one->second;
}

void Presence::expire() {
  const auto now = scheduler_.now();
  std::vector<Line> over;
  std::vector<std::pair<Line, OwnerId>> faded;
  for (const auto& [line, state] : lines_) {
    if (state.until <= now) over.push_back(line);
  }
  for (const auto& [id, all] : components_) {
    for (const auto& [line, one] : all) {
      if (one.until <= now) faded.emplace_back(line, id);
    }
  }
  for (const auto& [line, id] : faded) remove(line, id, PeerEvent::kLost);
  for (const auto& line : over) {
    const auto shown = shown_on(line);
    lines_.erase(line);
    add_bytes(line.user, 0, kShownOverhead);
    for (const auto id : shown) remove(line, id, PeerEvent::kLost);
    callbacks_.forgotten(line);
  }
  for (const auto& [line, state] : lines_) expiry_.advance_to(state.until);
  for (const auto& [id, all] : components_) {
    for (const auto& [line, one] : all) expiry_.advance_to(one.until);
  }
}

/// A line that goes may come back: until then what is there stays.
bool Presence::counts(OwnerId id, const Component& one) const {
  const auto& line = one.as->line;
  const auto found = lines_.find(line);
  if (one.doubted || found == lines_.end() || found->second.shown.lease <= Duration(0)) return false;
  return !callbacks_.allowed || callbacks_.allowed(line, id);
}

/// Of two with one id the component itself and no stand-in, then the one that began first, unless it began again; of
/// one start its newest connection.
bool Presence::is_better(const Reached& one, const Reached& other) const {
  if (is_stand_in(one) != is_stand_in(other)) return is_stand_in(other);
  const auto& of_one = lines_.at(one.line);
  const auto& of_other = lines_.at(other.line);
  if (is_same(one, other)) return of_one.shown.count > of_other.shown.count;
  const bool again = one.line.user == other.line.user && one.shown.host == other.shown.host;
  return again ? one.shown.incarnation > other.shown.incarnation : one.shown.incarnation < other.shown.incarnation;
}

Presence::Shown Presence::best(OwnerId id) const {
  const auto found = components_.find(id);
  if (found == components_.end()) return nullptr;
  Shown chosen;
  // No user takes an id from another user who is there.
  const auto before = reached_.find(id);
  const auto stays = before == reached_.end() ? found->second.end() : found->second.find(before->second->line);
  const bool stays_there = stays != found->second.end() && counts(id, stays->second) && !is_stand_in(*stays->second.as);
  for (const auto& [line, one] : found->second) {
    if (!counts(id, one) || (stays_there && line.user != stays->first.user)) continue;
    if (!chosen || is_better(*one.as, *chosen)) chosen = one.as;
  }
  return chosen;
}

void Presence::review_all() {
  std::vector<OwnerId> ids;
  for (const auto& one : components_) ids.push_back(one.first);
  for (const auto id : ids) review(id, PeerEvent::kLost);
}

/// Removes what the same start showed on earlier connections whose end was not reported. Else that would stay for a
/// lease after this connection ended.
void Presence::forget_former(OwnerId id, const Reached& now) {
  std::erase_if(components_.at(id), [&](const auto& one) {
    const auto& state = lines_.at(one.first);
    const bool former = one.first != now.line && is_same(*one.second.as, now) && !state.seen;
    if (former) add_bytes(one.first.user, 0, size_of(*one.second.as));
    return former;
  });
}

void Presence::review(OwnerId id, PeerEvent how) {
  const auto now = best(id);
  if (now && lines_.at(now->line).seen) forget_former(id, *now);
  const auto before = reached_.find(id);
  if (!now) {
    if (before == reached_.end()) return;
    reached_.erase(before);
  } else {
    if (before != reached_.end() && before->second->line == now->line && is_same(*before->second, *now) &&
        before->second->shown.summary == now->shown.summary)
      return;
    reached_.insert_or_assign(id, now);
  }
  callbacks_.changed(id, how);
}

std::vector<OwnerId> Presence::shown_on(const Line& line) const {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return {};
  return {found->second.ids.begin(), found->second.ids.end()};
}

Presence::Shown Presence::reached(OwnerId id) const {
  const auto found = reached_.find(id);
  return found == reached_.end() ? nullptr : found->second;
}

std::vector<OwnerId> Presence::all() const {
  std::vector<OwnerId> ids;
  for (const auto& [id, one] : reached_) ids.push_back(id);
  return ids;
}

std::vector<Presence::Shown> Presence::all_with(OwnerId id) const {
  std::vector<Shown> all;
  const auto found = components_.find(id);
  if (found == components_.end()) return all;
  for (const auto& [line, one] : found->second) {
    if (counts(id, one)) all.push_back(one.as);
  }
  return all;
}

}  // namespace rubicon::tuples::mqtt
