#include "history/intake.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <tuple>

#include "base/text.h"
#include "history/buckets.h"
#include "model/point_keys.h"

namespace rubicon::history {

namespace {

/// A point's value waits so long for its status and its description.
constexpr auto kPatience = std::chrono::seconds(5);
/// Times that differ more from the clock belong to a recording.
constexpr auto kLive = std::chrono::hours(1);
constexpr auto kFresh = std::chrono::seconds(2);
/// The last of equal values is stored before another one, if the first was longer ago: a line between the stored points
/// would otherwise rise or fall for minutes.
constexpr std::int64_t kSteady = 10'000;
constexpr std::size_t kMaxWordLength = 64;

using Pair = std::array<std::string_view, 2>;
constexpr std::array<Pair, 4> kUsualWords{Pair{"off", "on"}, Pair{"false", "true"}, Pair{"closed", "open"},
                                          Pair{"no", "yes"}};

WallTime time_of(const TupleView& tuple) {
  return tuple.user_time == WallTime() ? tuple.write_time : tuple.user_time;
}

bool near(WallTime a, WallTime b) {
  return (a > b ? a - b : b - a) <= kLive;
}

bool is_number_type(std::string_view data_type) {
  return data_type == "integer" || data_type == "real";
}

}  // namespace

std::size_t Intake::Hash::operator()(const std::pair<OwnerId, std::string_view>& name) const {
  return std::hash<std::string_view>()(name.second) ^ static_cast<std::size_t>(number(name.first)) * 0x9e3779b97f4a7c15;
}

void Intake::seed(const std::vector<Declaration>& known) {
  for (const auto& declaration : known) {
    const Instant long_ago{{}, SteadyTime(-kPatience)};
    auto* series = series_of(declaration.name.owner, declaration.name.key, long_ago);
    if (!series) return;
    series->declaration = declaration;
    series->kind_known = true;
    series->seeded = true;
  }
}

Intake::Series* Intake::series_of(OwnerId owner, std::string_view key, const Instant& now) {
  if (const auto found = slots_.find({owner, key}); found != slots_.end()) return &series_[found->second];
  if (series_.size() >= kMaxSeries) {
    ++refused_;
    return nullptr;
  }
  auto& series = series_.emplace_back();
  series.slot = static_cast<Slot>(series_.size() - 1);
  series.declaration.name = {owner, std::string(key)};
  series.point = model::point_of(key).has_value();
  series.excluded = std::any_of(exclude_.begin(), exclude_.end(),
                                [&](const Pattern& pattern) { return pattern.matches(owner, key); });
  series.seen = now.steady;
  slots_.emplace(std::pair(owner, std::string_view(series.declaration.name.key)), series.slot);
  return &series;
}

void Intake::changed(const TupleView& tuple, const Instant& now) {
  const auto part = model::last_part(tuple.key);
  if (part == "command") return;
  const bool status = part == "status", description = part == "description";
  if (!status && !description) {
    auto* series = series_of(tuple.owner, tuple.key, now);
    if (series && !series->excluded) value(*series, tuple.value, time_of(tuple), now);
    return;
  }
  if (!model::point_of(tuple.key)) return;
  key_ = model::parent_key(tuple.key);
  key_ += ".value";
  auto* series = series_of(tuple.owner, key_, now);
  if (!series || series->excluded) return;
  if (description) return describe(*series, tuple.value, now);
  if (const auto heard = model::heard_quality_from_json(tuple.value))
    quality(*series, heard->quality, tuple.write_time, now);
}

void Intake::gone(OwnerId owner, std::string_view key, const Instant& now) {
  const auto found = slots_.find({owner, key});
  if (found == slots_.end()) return;
  auto& series = series_[found->second];
  mark_gap(series, now.wall);
  series.held.reset();
  series.quality.reset();
}

/// A first value may arrive before the status and the description of its point.
bool Intake::early(const Series& series, const Instant& now) {
  return now.steady - series.seen < kPatience;
}

void Intake::value(Series& series, std::string_view text, WallTime time, const Instant& now) {
  if (text.empty()) return;
  const bool first = series.point && !series.last && (!series.quality || !series.described);
  series.live = near(time, now.wall);
  if ((first && early(series, now)) || !series.observed()) {
    series.held = Held{time, std::string(text)};
    return;
  }
  series.held.reset();
  // The file has a gap since the history before this one ended: the value is in force again since now.
  const bool returns = !series.event && series.seeded && !series.last && series.live && now.wall - time > kFresh;
  store(series, text, returns ? now.wall : time);
}

void Intake::quality(Series& series, Quality quality, WallTime time, const Instant& now) {
  const bool before = series.observed();
  series.quality = quality;
  const bool after = series.observed();
  if (before && !after) {
    mark_gap(series, time);
    if (!series.held && !series.text.empty() && !series.event) series.held = Held{WallTime(), series.text};
  }
  if (after && series.held) {
    // The value from before the gap is true again since now.
    if (series.held->time == WallTime()) series.held->time = time;
    release(series, now);
  }
}

void Intake::describe(Series& series, std::string_view json, const Instant& now) {
  const auto description = model::point_description_from_json(json);
  if (!description) return;
  series.described = true;
  series.data_type = description->data_type;
  series.event = description->report == "event";
  if (series.declaration.unit != description->unit) {
    series.declaration.unit = description->unit;
    series.declared = false;
  }
  if (!series.kind_known && series.declaration.words.empty()) {
    for (const auto& word : description->words) {
      if (series.declaration.words.size() < kMaxWords && word.text.size() <= kMaxWordLength)
        series.declaration.words.push_back(word.text);
    }
  }
  if (series.observed()) release(series, now);
}

/// Stores the value that waits, if it waited for nothing else.
void Intake::release(Series& series, const Instant& now) {
  if (!series.held) return;
  auto held = std::move(*series.held);
  series.held.reset();
  value(series, held.text, held.time, now);
}

void Intake::store(Series& series, std::string_view text, WallTime time) {
  if (!series.kind_known) decide_kind(series, text);
  const auto at = to_milliseconds(time);
  switch (series.declaration.kind) {
    case SeriesKind::kNumber: return store_number(series, text, at);
    case SeriesKind::kWords: return store_word(series, text, at);
    case SeriesKind::kText: return store_text(series, text, at);
  }
}

void Intake::decide_kind(Series& series, std::string_view text) {
  series.kind_known = true;
  auto& declaration = series.declaration;
  const auto usual = std::find_if(kUsualWords.begin(), kUsualWords.end(),
                                  [&](const Pair& pair) { return text == pair[0] || text == pair[1]; });
  const bool number = base::parse_number<double>(text).has_value();
  if (series.data_type == "boolean" || series.data_type == "enumeration") {
    declaration.kind = SeriesKind::kWords;
  } else if (is_number_type(series.data_type) || (number && series.data_type.empty())) {
    declaration.kind = SeriesKind::kNumber;
  } else if (usual != kUsualWords.end()) {
    declaration.kind = SeriesKind::kWords;
  } else {
    declaration.kind = number && series.data_type == "unknown" ? SeriesKind::kNumber : SeriesKind::kText;
  }
  if (declaration.kind != SeriesKind::kWords) declaration.words.clear();
  if (declaration.kind == SeriesKind::kWords && declaration.words.empty() && usual != kUsualWords.end())
    declaration.words.assign(usual->begin(), usual->end());
}

void Intake::store_number(Series& series, std::string_view text, std::int64_t time) {
  const auto number = base::parse_number<double>(text);
  if (!number || !std::isfinite(*number)) return refuse(series);
  series.text = text;
  put(series, {time, *number});
}

void Intake::store_word(Series& series, std::string_view text, std::int64_t time) {
  auto& words = series.declaration.words;
  auto found = std::find(words.begin(), words.end(), text);
  if (found == words.end()) {
    if (words.size() == kMaxWords || text.size() > kMaxWordLength) return refuse(series);
    words.emplace_back(text);
    series.declared = false;
    found = words.end() - 1;
  }
  series.text = text;
  put(series, {time, static_cast<double>(found - words.begin())});
}

void Intake::store_text(Series& series, std::string_view text, std::int64_t time) {
  if (text.size() > kMaxTextLength) return refuse(series);
  if (series.last && !series.last->gap() && series.text == text && !series.event) return;
  if (!write_gap(series) || !room(series, kTextBytes + text.size()))
    return drop(series, series.last ? series.last->time + 1 : time);
  series.text = text;
  series.last = Point{time, 0};
  batch_.texts.push_back({series.slot, time, series.text});
}

void Intake::put(Series& series, const Point& point) {
  const auto& last = series.last;
  const bool same = last && !last->gap() && last->value == point.value;
  const auto equal_for = series.event ? 1 : kRepeat;  // an event that comes by two patterns has one time
  if (same && point.time >= last->time && point.time - last->time < equal_for) {
    if (point.time > last->time) series.skipped = point.time;
    return;
  }
  const bool steady = last && series.skipped != 0 && series.skipped - last->time > kSteady;
  if (steady && !same && series.declaration.kind == SeriesKind::kNumber && series.skipped < point.time)
    emit(series, {series.skipped, last->value});
  emit(series, point);
}

/// From here on there is no good value.
void Intake::mark_gap(Series& series, WallTime time) {
  if (!series.last || series.last->gap()) return;
  auto at = series.live ? to_milliseconds(time) : series.last->time + 1;
  if (series.declaration.kind == SeriesKind::kText) {
    series.last = Point{std::max(at, series.last->time + 1), kGap};
    series.gap_due = true;
    std::ignore = write_gap(series);
    return;
  }
  if (series.skipped != 0) emit(series, {series.skipped, series.last->value});
  // A clock that was set back: the gap begins then by the new one.
  if (at <= series.last->time && series.last->time - at < kRepeat) at = series.last->time + 1;
  emit(series, {at, kGap});
}

/// Writes the mark of a gap that is due. False: there is no room for it yet.
bool Intake::write_gap(Series& series) {
  if (!series.gap_due) return true;
  const bool text = series.declaration.kind == SeriesKind::kText;
  if (!room(series, text ? kTextBytes : kPointBytes)) return false;
  if (text) {
    batch_.texts.push_back({series.slot, series.last->time, ""});
  } else {
    batch_.points.push_back({series.slot, *series.last});
  }
  series.gap_due = false;
  return true;
}

bool Intake::room(Series& series, std::size_t bytes) {
  if (bytes > limit_ || bytes_ > limit_ - bytes) return false;
  bytes_ += bytes;
  if (!series.declared) {
    batch_.declared.emplace_back(series.slot, series.declaration);
    series.declared = true;
  }
  return true;
}

/// Else a graph would draw a line across the time without points.
void Intake::drop(Series& series, std::int64_t gap) {
  ++dropped_;
  if (!series.last || series.last->gap()) return;
  series.last = Point{gap, kGap};
  series.gap_due = true;
}

void Intake::refuse(Series& series) {
  ++unfit_;
  if (std::exchange(series.unfit, true) || named_.size() == kMaxNamedEntries) return;
  named_.push_back(series.declaration);
}

void Intake::emit(Series& series, const Point& point) {
  series.skipped = 0;
  if (!write_gap(series) || !room(series, kPointBytes))
    return drop(series, point.gap() || !series.last ? point.time : series.last->time + 1);
  series.last = point;
  batch_.points.push_back({series.slot, point});
}

void Intake::tick(const Instant& now) {
  const auto at = to_milliseconds(now.wall);
  for (auto& series : series_) {
    std::ignore = write_gap(series);
    if (series.held && !early(series, now) && series.observed()) release(series, now);
    const auto& last = series.last;
    if (!last || last->gap() || !series.live || series.declaration.kind == SeriesKind::kText || series.event) continue;
    const bool due = at - last->time >= kRepeat || last->time - at >= kRepeat;
    if (due) emit(series, {at, last->value});
  }
}

Batch Intake::take(WallTime now) {
  Batch batch = std::move(batch_);
  batch_ = Batch();
  bytes_ = 0;
  batch.time = now;
  return batch;
}

}  // namespace rubicon::history
