#include "networks/zigbee/device/known_values.h"

#include <algorithm>
#include <array>
#include <utility>

namespace rubicon::networks::zigbee::device {

namespace {

using Points = std::vector<exposes::MappedPoint>;

bool are_same(const Property& one, const Points& its_points, const Property& other, const Points& other_points) {
  return std::equal(one.points.begin(), one.points.end(), other.points.begin(), other.points.end(),
                    [&](std::size_t a, std::size_t b) { return its_points[a] == other_points[b]; });
}

}  // namespace

void Properties::set_points(const Points& before, const Points& points) {
  auto old = std::exchange(all_, {});
  const auto known = std::exchange(by_name_, {});
  add(points);
  for (auto& property : all_) {
    const auto found = known.find(property.name);
    if (found == known.end()) continue;
    auto& its_past = old[found->second];
    if (its_past.unproven || are_same(property, points, its_past, before))
      static_cast<KnownValue&>(property) = std::move(its_past);
  }
}

void Properties::add(const Points& points) {
  of_point_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const auto [entry, fresh] = by_name_.emplace(point.property, all_.size());
    if (fresh) {
      auto& property = all_.emplace_back();
      property.name = point.property;
      property.of_the_link = point.property == "linkquality";
    }
    auto& property = all_[entry->second];
    property.points.push_back(i);
    property.published |= point.access.published;
    property.settable |= point.access.settable;
    property.gettable |= point.access.gettable;
    property.event |= point.event;
    of_point_.push_back(entry->second);
  }
}

Property* Properties::find(std::string_view key) {
  const auto found = by_name_.find(key);
  return found == by_name_.end() ? nullptr : &all_[found->second];
}

namespace {

using std::chrono::milliseconds;

constexpr std::array<Duration, 3> kAskAfter{milliseconds(300), milliseconds(1000), milliseconds(3000)};
constexpr Duration kNoEchoAfter = std::chrono::seconds(2);
/// Pause before another property may be asked for.
constexpr Duration kQuestionTime = std::chrono::seconds(1);
/// Time for the acknowledgement of a set.
constexpr Duration kAcknowledgeTime = std::chrono::seconds(2);
/// Pause if there is no place for a question at the moment.
constexpr Duration kTryAgain = milliseconds(300);
/// After all attempts the device must be heard before the next one, and this pause lies between them.
constexpr Duration kRest = std::chrono::minutes(1);

}  // namespace

Verification::Verification(Scheduler& scheduler, Callbacks calls)
    : scheduler_(scheduler), callbacks_(std::move(calls)), deadline_(scheduler, [this] { step(); }) {}

Verification::Item* Verification::find(std::size_t property) {
  const auto found =
      std::find_if(items_.begin(), items_.end(), [&](const Item& item) { return item.property == property; });
  return found == items_.end() ? nullptr : &*found;
}

bool Verification::is_running(std::size_t property) const {
  return std::any_of(items_.begin(), items_.end(), [&](const Item& item) { return item.property == property; });
}

bool Verification::asks(std::size_t property) const {
  return open_ == property && scheduler_.now() < open_until_ &&
         std::any_of(items_.begin(), items_.end(),
                     [&](const Item& item) { return item.property == property && item.cause == Cause::kEcho; });
}

void Verification::start(std::size_t property, Cause cause, bool can_ask, std::optional<WallTime> seen,
                         std::optional<WallTime> before) {
  auto* item = find(property);
  if (!item) item = &items_.emplace_back();
  *item = {};
  item->property = property;
  item->cause = cause;
  item->can_ask = can_ask;
  item->start = scheduler_.now();
  item->due = item->start + (cause == Cause::kNoEchoYet ? kNoEchoAfter : kAskAfter[0]);
  item->not_before = seen;
  item->answering = !seen || !before || *seen > *before;
  if (open_ == property) open_.reset();
  schedule();
}

void Verification::reported(std::size_t property, bool ends) {
  auto* item = find(property);
  if (open_ == property) open_.reset();
  if (!item) return;
  item->candidate_until = SteadyTime::max();
  const bool goes_on = !ends && item->can_ask && item->cause != Cause::kForeign && item->asked < kAskAfter.size();
  if (!goes_on) items_.erase(items_.begin() + (item - items_.data()));
  schedule();
}

void Verification::set_published() {
  if (std::exchange(set_at_, scheduler_.now()) != scheduler_.now()) ++acknowledgements_;
  auto* asked = open_ ? find(*open_) : nullptr;
  open_.reset();  // what comes now may belong to the set
  if (!asked) return;
  if (asked->asked > 0) --asked->asked;
  asked->due = scheduler_.now();
  schedule();
}

bool Verification::acknowledges_set(const Heard& heard) {
  if (acknowledgements_ > 0 && scheduler_.now() > set_at_ + kAcknowledgeTime) acknowledgements_ = 0;
  if (acknowledgements_ == 0 || !heard.last_seen || !heard.later || !heard.quiet) return false;
  --acknowledgements_;
  return true;
}

void Verification::message(const Heard& heard) {
  const bool acknowledges = acknowledges_set(heard);
  for (auto& item : items_) consider(item, heard, acknowledges);
  schedule();
}

void Verification::consider(Item& item, const Heard& heard, bool acknowledges) {
  if (!std::exchange(item.begun, true) || !heard.later) return;
  item.heard = true;
  if (!may_prove(item, heard, acknowledges) || item.candidate_until != SteadyTime::max()) return;
  item.candidate_until = scheduler_.now() + kSettling;
  item.candidate_seen = heard.last_seen;
}

bool Verification::may_prove(Item& item, const Heard& heard, bool acknowledges) const {
  if (item.cause == Cause::kNoEchoYet || item.cause == Cause::kNoEchoes) return false;
  if (item.can_ask) return heard.quiet && !acknowledges && open_ == item.property;
  if (!heard.last_seen) return false;  // any message repeats the echo
  if (!item.not_before) return heard.quiet;
  if (*heard.last_seen <= *item.not_before + kSameExchange) return false;
  if (!std::exchange(item.answering, true)) {  // the answer to the set, which the echo overtook
    item.not_before = heard.last_seen;
    return false;
  }
  return heard.quiet;
}

void Verification::step() {
  settle_candidates();
  ask_next();
  schedule();
}

void Verification::settle_candidates() {
  const auto now = scheduler_.now();
  std::vector<Item> proven;
  std::erase_if(items_, [&](const Item& item) {
    if (item.candidate_until > now) return false;
    proven.push_back(item);
    return true;
  });
  for (const auto& item : proven) {
    if (open_ == item.property) open_.reset();
    callbacks_.proven(item.property, item.candidate_seen);
  }
}

void Verification::ask_next() {
  const auto now = scheduler_.now();
  if (open_ && open_until_ <= now) open_.reset();
  if (now < quiet_from()) return;
  for (auto& item : items_) {
    const bool rests = item.asked >= kAskAfter.size() && !item.heard;
    if (open_ || !item.can_ask || rests || item.due > now || item.candidate_until != SteadyTime::max()) continue;
    if (!ask(item)) item.due = now + kTryAgain;
  }
  std::erase_if(items_, [](const Item& item) { return item.cause == Cause::kNoEchoYet && item.asked > 0; });
}

bool Verification::ask(Item& item) {
  if (!callbacks_.ask(item.property, item.cause != Cause::kForeign)) return false;
  const auto now = scheduler_.now();
  open_ = item.property;
  open_until_ = now + kQuestionTime;
  item.heard = false;
  if (item.asked < kAskAfter.size()) ++item.asked;
  const bool last = item.asked == kAskAfter.size();
  item.due = last ? now + kRest : std::max(now + kAskAfter[0], item.start + kAskAfter[item.asked]);
  return true;
}

/// A question during the exchange for a set could be answered by that.
SteadyTime Verification::quiet_from() const {
  return set_at_ == SteadyTime::min() ? set_at_ : set_at_ + kAskAfter[0];
}

void Verification::schedule() {
  auto next = open_ ? open_until_ : SteadyTime::max();
  for (const auto& item : items_) {
    next = std::min(next, item.candidate_until);
    const bool rests = item.asked >= kAskAfter.size() && !item.heard;
    if (item.can_ask && !rests && !open_ && item.candidate_until == SteadyTime::max())
      next = std::min(next, std::max(item.due, quiet_from()));
  }
  deadline_.set_at(next);
}

void Verification::clear() {
  items_.clear();
  open_.reset();
  acknowledgements_ = 0;
  deadline_.clear();
}

}  // namespace rubicon::networks::zigbee::device
