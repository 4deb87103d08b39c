#include "tuples/mqtt/presence.h"

#include <algorithm>
#include <utility>

#include "tuples/stand_in.h"

namespace rubicon::tuples::mqtt {

namespace {

/// Of a connection; of a component with what links keep of it.
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

Presence::Presence(Scheduler& scheduler, Calls calls)
    : scheduler_(scheduler), calls_(std::move(calls)), expiry_(scheduler, [this] { expire(); }) {}

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
  review_line(line, PeerEvent::kLost);
  return true;
}

/// What an earlier connection showed may be emptied before its successor is read: end_reading() decides about what was
/// not seen.
void Presence::hide(const Line& line) {
  const auto found = lines_.find(line);
  if (found == lines_.end() || !found->second.here || !found->second.seen) return;
  found->second.here = false;
  end_at(found->second, scheduler_.now() + kReturn);
}

void Presence::end_at(LineState& line, SteadyTime when) {
  line.until = std::min(line.until, when);
  expiry_.advance_to(line.until);
}

bool Presence::show(const Line& line, OwnerId id, ComponentShown shown) {
  Reached one{line, std::move(shown)};
  auto& all = components_[id];
  const auto known = all.find(line);
  const auto before = known == all.end() ? 0 : size_of(known->second);
  const bool is_new = !lines_.contains(line);
  if (!add_bytes(line.user, size_of(one) + (is_new ? kShownOverhead : 0), before)) {
    if (all.empty()) components_.erase(id);
    return false;
  }
  all.insert_or_assign(line, std::move(one));
  auto& state = lines_[line];
  if (is_new) {  // its own topic may follow
    end_at(state, scheduler_.now() + kReturn);
    state.seen = true;
  }
  state.components[id] = {true};
  review(id, PeerEvent::kLost);
  return true;
}

void Presence::fade(const Line& line, OwnerId id) {
  auto* one = find(line, id);
  if (!one || !lines_.at(line).seen) return;
  one->until = std::min(one->until, scheduler_.now() + kReturn);
  expiry_.advance_to(one->until);
}

void Presence::remove(const Line& line, OwnerId id, PeerEvent how) {
  const auto found = components_.find(id);
  if (found == components_.end()) return;
  const auto one = found->second.find(line);
  if (one == found->second.end()) return;
  add_bytes(line.user, 0, size_of(one->second));
  found->second.erase(one);
  if (found->second.empty()) components_.erase(found);
  if (const auto state = lines_.find(line); state != lines_.end()) state->second.components.erase(id);
  review(id, how);
}

void Presence::begin_reading() {
  for (auto& [line, state] : lines_) {
    state.seen = false;
    for (auto& [id, one] : state.components) one.seen = false;
  }
}

void Presence::cut() {
  begin_reading();
  for (auto& [line, state] : lines_) {
    if (state.here) end_at(state, scheduler_.now() + state.shown.lease);
  }
}

void Presence::end_reading() {
  std::vector<std::pair<Line, OwnerId>> gone;
  for (auto& [line, state] : lines_) {
    if (state.seen) {
      for (const auto& [id, one] : state.components) {
        if (!one.seen) gone.emplace_back(line, id);
      }
    } else if (state.here) {
      state.here = false;
      state.until = scheduler_.now() + std::max(state.shown.lease, kReturn);
      expiry_.advance_to(state.until);
    }
  }
  for (const auto& [line, id] : gone) fade(line, id);
}

void Presence::doubt(const Line& line, OwnerId id) {
  auto* one = find(line, id);
  if (one && !std::exchange(one->doubted, true)) review(id, PeerEvent::kLost);
}

void Presence::believe(const Line& line, OwnerId id) {
  auto* one = find(line, id);
  if (one && std::exchange(one->doubted, false)) review(id, PeerEvent::kLost);
}

std::vector<std::pair<OwnerId, Reached>> Presence::doubted() const {
  std::vector<std::pair<OwnerId, Reached>> all;
  for (const auto& [line, state] : lines_) {
    for (const auto& [id, one] : state.components) {
      if (!one.doubted) continue;
      const auto known = components_.find(id);
      if (known != components_.end() && known->second.contains(line)) all.emplace_back(id, known->second.at(line));
    }
  }
  return all;
}

Presence::Component* Presence::find(const Line& line, OwnerId id) {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return nullptr;
  const auto one = found->second.components.find(id);
  return one == found->second.components.end() ? nullptr : &one->second;
}

void Presence::expire() {
  const auto now = scheduler_.now();
  std::vector<Line> over;
  std::vector<std::pair<Line, OwnerId>> faded;
  for (const auto& [line, state] : lines_) {
    if (state.until <= now) over.push_back(line);
    for (const auto& [id, one] : state.components) {
      if (one.until <= now) faded.emplace_back(line, id);
    }
  }
  for (const auto& [line, id] : faded) remove(line, id, PeerEvent::kLost);
  for (const auto& line : over) {
    const auto shown = shown_on(line);
    lines_.erase(line);
    add_bytes(line.user, 0, kShownOverhead);
    for (const auto id : shown) remove(line, id, PeerEvent::kLost);
    calls_.forgotten(line);
  }
  for (const auto& [line, state] : lines_) {
    expiry_.advance_to(state.until);
    for (const auto& [id, one] : state.components) expiry_.advance_to(one.until);
  }
}

/// A line that goes may come back: until then what is there stays.
bool Presence::counts(const Line& line, OwnerId id) const {
  const auto found = lines_.find(line);
  if (found == lines_.end() || found->second.shown.lease <= Duration(0)) return false;
  const auto one = found->second.components.find(id);
  if (one == found->second.components.end() || one->second.doubted) return false;
  return !calls_.allowed || calls_.allowed(line, id);
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

const Reached* Presence::best(OwnerId id) const {
  const auto found = components_.find(id);
  if (found == components_.end()) return nullptr;
  const Reached* chosen = nullptr;
  // Nobody takes an id from another user who is there.
  const auto before = reached_.find(id);
  const auto stays = before == reached_.end() ? found->second.end() : found->second.find(before->second->line);
  const bool stays_there = stays != found->second.end() && counts(stays->first, id) && !is_stand_in(stays->second);
  for (const auto& [line, one] : found->second) {
    if (!counts(line, id) || (stays_there && line.user != stays->first.user)) continue;
    if (!chosen || is_better(one, *chosen)) chosen = &one;
  }
  return chosen;
}

void Presence::review_line(const Line& line, PeerEvent how) {
  for (const auto id : shown_on(line)) review(id, how);
}

void Presence::review_all() {
  std::vector<OwnerId> ids;
  for (const auto& one : components_) ids.push_back(one.first);
  for (const auto id : ids) review(id, PeerEvent::kLost);
}

/// What the same start showed on earlier connections, if only their ends were not told: else it would stay for a lease
/// after this one ended.
void Presence::forget_former(OwnerId id, const Reached& now) {
  std::erase_if(components_.at(id), [&](const auto& one) {
    const auto& state = lines_.at(one.first);
    const bool former = one.first != now.line && is_same(one.second, now) && !state.seen;
    if (former) add_bytes(one.first.user, 0, size_of(one.second));
    return former;
  });
}

void Presence::review(OwnerId id, PeerEvent how) {
  const auto* now = best(id);
  if (now && lines_.at(now->line).seen) forget_former(id, *now);
  const auto before = reached_.find(id);
  if (!now) {
    if (before == reached_.end()) return;
    reached_.erase(before);
  } else {
    if (before != reached_.end() && before->second->line == now->line && is_same(*before->second, *now) &&
        before->second->shown.summary == now->shown.summary)
      return;
    reached_.insert_or_assign(id, std::make_shared<const Reached>(*now));
  }
  calls_.changed(id, how);
}

std::vector<OwnerId> Presence::shown_on(const Line& line) const {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return {};
  std::vector<OwnerId> ids;
  for (const auto& [id, one] : found->second.components) ids.push_back(id);
  return ids;
}

std::shared_ptr<const Reached> Presence::reached(OwnerId id) const {
  const auto found = reached_.find(id);
  return found == reached_.end() ? nullptr : found->second;
}

std::vector<OwnerId> Presence::all() const {
  std::vector<OwnerId> ids;
  for (const auto& [id, one] : reached_) ids.push_back(id);
  return ids;
}

std::vector<Reached> Presence::all_with(OwnerId id) const {
  std::vector<Reached> all;
  const auto found = components_.find(id);
  if (found == components_.end()) return all;
  for (const auto& [line, one] : found->second) {
    if (counts(line, id)) all.push_back(one);
  }
  return all;
}

}  // namespace rubicon::tuples::mqtt
