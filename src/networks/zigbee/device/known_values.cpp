#include "networks/zigbee/device/known_values.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace rubicon::networks::zigbee::device {

namespace {

using Points = std::vector<exposes::MappedPoint>;

std::vector<std::size_t> points_with(const std::vector<std::uint32_t>& of_point, std::size_t property) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < of_point.size(); ++i) {
    if (of_point[i] == property) found.push_back(i);
  }
  return found;
}

}  // namespace

void Properties::set_points(const Points& before, const Points& points) {
  auto old = std::exchange(all_, {});
  const auto old_by_name = std::exchange(by_name_, {});
  const auto old_of_point = std::exchange(of_point_, {});
  add(points);
  const auto are_same = [&](std::size_t a, std::size_t b) { return points[a] == before[b]; };
  for (auto& property : all_) {
    auto* past = find(old, old_by_name, property.name);
    if (!past) continue;
    const auto place = static_cast<std::size_t>(past - old.data());
    if (past->unproven || std::ranges::equal(points_of(property), points_with(old_of_point, place), are_same))
      static_cast<KnownValue&>(property) = std::move(*past);
  }
}

void Properties::add(const Points& points) {
  std::unordered_map<std::string_view, std::uint32_t> places;
  of_point_.reserve(points.size());
  all_.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const auto [entry, fresh] = places.emplace(point.property, static_cast<std::uint32_t>(all_.size()));
    if (fresh) {
      all_.emplace_back().name = point.property;
    }
    auto& property = all_[entry->second];
    property.published |= point.access.published;
    property.settable |= point.access.settable;
    property.gettable |= point.access.gettable;
    property.event |= point.event;
    of_point_.push_back(entry->second);
  }
  by_name_.resize(all_.size());
  std::iota(by_name_.begin(), by_name_.end(), std::uint32_t{0});
  std::ranges::sort(by_name_, {}, [this](std::uint32_t one) { return all_[one].name; });
}

std::vector<std::size_t> Properties::points_of(const Property& property) const {
  return points_with(of_point_, index_of(property));
}

Property* Properties::find(std::string_view key) {
  return find(all_, by_name_, key);
}

Property* Properties::find(std::vector<Property>& all, const std::vector<std::uint32_t>& by_name,
                           std::string_view key) {
  const auto name_of = [&all](std::uint32_t one) { return all[one].name; };
  const auto found = std::ranges::lower_bound(by_name, key, {}, name_of);
  return found == by_name.end() || all[*found].name != key ? nullptr : &all[*found];
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
