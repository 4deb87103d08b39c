#include "history/keeper.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <new>
#include <tuple>

#include "base/clocks.h"
#include "history/buckets.h"
#include "history/store.h"

namespace rubicon::history {

using sqlite::Query;

namespace {

constexpr Duration kRoundEvery = std::chrono::hours(1);
constexpr Duration kLookEvery = std::chrono::minutes(1);  // at the size, and at the disk
constexpr int kFastest = 4;                               // clock of the machine : time that passed
/// A clock before 2026 was never set.
constexpr WallTime kPlausible = WallTime(std::chrono::seconds(1'767'225'600));
/// What the disk should have left: this, and of a small history a tenth of it.
constexpr std::uint64_t kReserve = 64'000'000;
/// How long what stays for ever counts as lasting while the file is too large.
constexpr std::int64_t kForEverRaw = 3'650 * kDay, kForEverHours = 36'500 * kDay;
constexpr std::size_t kSeriesAtOnce = 100;
constexpr int kBlocksAtOnce = 50;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 4;
constexpr const char* kDoing = "removing what is old";
// The newest text of a series stays, because it is in force; an empty one begins a gap.
constexpr const char* kFirstText =
    "SELECT time FROM text WHERE series=?1 AND (value='' OR time<(SELECT max(time) FROM text WHERE series=?1)) ORDER "
    "BY time LIMIT 1";
constexpr const char* kRemoveTexts =
    "DELETE FROM text WHERE series=?1 AND time<?2 AND (value='' OR time<(SELECT max(time) FROM text WHERE series=?1))";

}  // namespace

Result<void> Retention::advance(SteadyTime now, WallTime wall) {
  if (!started_) {
    const auto kept = store_.meta("clock");
    if (!kept) return fail(kept.error());
    if (*kept) highest_ = clock_ = from_milliseconds(**kept);
    last_ = next_round_ = next_look_ = now;
    started_ = true;
  }
  const auto passed = std::chrono::duration_cast<std::chrono::microseconds>(kFastest * (now - last_));
  last_ = now;
  clock_ = highest_ ? std::min(wall, std::max(*highest_, clock_ + passed)) : wall;
  if (highest_ || wall >= kPlausible) highest_ = std::max(highest_.value_or(clock_), clock_);
  return {};
}

Result<std::string> Retention::step(SteadyTime now, WallTime wall, std::optional<std::uint64_t> free) {
  if (auto done = advance(now, wall); !done) return fail(done.error());
  std::string said;
  if (!in_round_) {
    if (now < next_look_) return said;
    next_look_ = now + kLookEvery;
    const auto why = too_large(free);
    if (!why) return why;
    if (why->empty() && now < next_round_) return said;
    if (auto done = begin_round(); !done) return fail(done.error());
    if (!why->empty()) {
      auto shrunk = shrink(*why);
      if (!shrunk) return shrunk;
      said = std::move(*shrunk);
    }
    in_round_ = true;
    next_round_ = now + kRoundEvery;
  }
  removed_.clear();
  auto done = store_.transact([this] { return slice(); });
  if (!done) return fail(done.error());
  for (const auto row : removed_) store_.forget(row);
  return said;
}

Result<void> Retention::begin_round() {
  next_row_ = 0;
  blocks_before_ = texts_before_ = hours_before_ = kNever;
  if (!highest_) return {};
  const auto clock = to_milliseconds(clock_);
  if (rules_.raw) blocks_before_ = texts_before_ = floor_to(clock - milliseconds(*rules_.raw), kHour);
  if (rules_.hours) hours_before_ = clock - milliseconds(*rules_.hours);
  return store_.put_meta("clock", to_milliseconds(*highest_));
}

Result<std::string> Retention::too_large(std::optional<std::uint64_t> free) {
  auto& database = store_.database();
  const auto pages = database.number("PRAGMA page_count", "measuring");
  const auto unused = database.number("PRAGMA freelist_count", "measuring");
  const auto size = database.number("PRAGMA page_size", "measuring");
  for (const auto* one : {&pages, &unused, &size}) {
    if (!*one) return fail(one->error());
  }
  const auto used = static_cast<std::uint64_t>(std::max<std::int64_t>(*pages - *unused, 0) * *size);
  if (used > rules_.size) return fmt::format("{}: larger than {} bytes", store_.path(), rules_.size);
  // The file itself has free pages too, from removed rows. Without a reserve not even removing would be possible.
  const auto room = free.value_or(kReserve) + static_cast<std::uint64_t>(*unused * *size);
  if (room < std::min(kReserve, used / 10)) return fmt::format("{}: the disk is almost full", store_.path());
  return std::string();
}

/// Lets one more day go; of the last two days, an hour.
Result<std::string> Retention::shrink(const std::string& why) {
  struct Part {
    const char *what, *first;
    std::int64_t lasts;
    std::int64_t& before;
  };
  const auto raw = rules_.raw ? milliseconds(*rules_.raw) : kForEverRaw;
  const auto hours = rules_.hours ? milliseconds(*rules_.hours) : kForEverHours;
  const std::array parts{
      Part{"points", "SELECT until FROM block WHERE series=? ORDER BY start LIMIT 1", raw, blocks_before_},
      Part{"texts", kFirstText, raw, texts_before_},
      Part{"summaries of hours", "SELECT start FROM hour WHERE series=? ORDER BY start LIMIT 1", hours, hours_before_}};
  const Part* oldest_part = nullptr;
  std::pair<double, std::int64_t> highest_age;  // as a part of how long it lasts; of equal ones the earlier time
  std::int64_t begin = 0;
  for (const auto& part : parts) {
    const auto first = oldest(part.first);
    if (!first) return fail(first.error());
    if (!*first) continue;
    const auto age = std::max<std::int64_t>(to_milliseconds(clock_) - **first, 0);
    const std::pair relative_age(static_cast<double>(age) / static_cast<double>(std::max<std::int64_t>(part.lasts, 1)),
                                 -**first);
    if (oldest_part && relative_age <= highest_age) continue;
    oldest_part = &part;
    highest_age = relative_age;
    begin = **first;
  }
  if (!oldest_part) return why + ", and nothing is left to remove";
  const auto width = store_.alive() - begin < 2 * kDay ? kHour : kDay;
  auto& before = oldest_part->before;
  before = std::max(before, floor_to(begin, width) + width);
  return fmt::format("{}: the {} before {} go", why, oldest_part->what,
                     base::utc_text(from_milliseconds(before), "%Y-%m-%d %H:%M"));
}

Result<void> Retention::slice() {
  auto next = store_.series().lower_bound(next_row_);
  for (std::size_t i = 0; i < kSeriesAtOnce && next != store_.series().end(); ++i) {
    const auto row = next->first;
    const auto more = slice_of(row);
    if (!more) return fail(more.error());
    next_row_ = row;
    if (*more) return {};  // the rest of this series in the next slice
    const auto empty = store_.remove_if_empty(row);
    if (!empty) return fail(empty.error());
    if (*empty) removed_.push_back(row);
    ++next;
    next_row_ = row + 1;
  }
  in_round_ = next != store_.series().end();
  return {};
}

/// True: the series has more to remove.
Result<bool> Retention::slice_of(SeriesRow row) {
  auto& database = store_.database();
  auto blocks = database.prepare(
      "SELECT start,part,data FROM block WHERE series=? AND start<? AND until<? ORDER BY start,part LIMIT ?", kDoing);
  if (!blocks) return fail(blocks.error());
  std::vector<std::pair<std::int64_t, std::int64_t>> gone;
  Points all;  // of several blocks, so that it is known how long the last of each was in force
  {
    Query query(*blocks);
    query.integer(row).integer(blocks_before_).integer(blocks_before_).integer(kBlocksAtOnce);
    while (true) {
      const auto there = query.next();
      if (!there) return fail(there.error());
      if (!*there) break;
      gone.emplace_back(query.integer_at(0), query.integer_at(1));
      if (const auto points = store_.codec().decode(query.blob_at(2))) {
        all.insert(all.end(), points->begin(), points->end());
      } else {
        store_.count_damage();
      }
    }
  }
  if (auto done = keep_hours(row, std::move(all)); !done) return fail(done.error());
  auto remove = database.prepare("DELETE FROM block WHERE series=? AND start=? AND part=?", kDoing);
  if (!remove) return fail(remove.error());
  for (const auto& [start, part] : gone) {
    if (auto done = Query(*remove).integer(row).integer(start).integer(part).run(); !done) return fail(done.error());
  }
  if (gone.size() == kBlocksAtOnce) return true;
  for (const auto& [sql, before] : {std::pair{"DELETE FROM hour WHERE series=? AND start<?", hours_before_},
                                    std::pair{kRemoveTexts, texts_before_}}) {
    auto old = database.prepare(sql, kDoing);
    if (!old) return fail(old.error());
    if (auto done = Query(*old).integer(row).integer(before).run(); !done) return fail(done.error());
  }
  return false;
}

Result<void> Retention::keep_hours(SeriesRow row, Points points) {
  std::map<std::int64_t, Summed> hours;
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.time < b.time; });
  for (const auto& point : points) {
    const auto hour = floor_to(point.time, kHour);
    if (!point.gap() && hour >= hours_before_) hours[hour].add(point.time, point.value);
  }
  each_hold(points, [&](double value, std::int64_t from, std::int64_t until) {
    const auto hour =
        hours.find(floor_to(from, kHour));  // what goes on into the next hour is known from both summaries
    if (hour != hours.end() && until <= hour->second.end) hour->second.hold(value, until - from);
  });
  // Columns without a value are those of an earlier release.
  auto put = store_.database().prepare(
      "INSERT INTO hour VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11) ON CONFLICT DO UPDATE SET until=max(until,?3),"
      "count=count+?4,minimum=min(minimum,?5),maximum=max(maximum,?6),sum=sum+?7,"
      "last=CASE WHEN ?3>=until THEN ?8 ELSE last END,area=area+?10,held=held+?11",
      "summing up an hour");
  if (!put) return fail(put.error());
  for (const auto& [hour, sum] : hours) {
    Query query(*put);
    query.integer(row).integer(hour).integer(sum.end).integer(sum.count);
    query.real(sum.minimum).real(sum.maximum).real(sum.sum).real(sum.last);
    query.real(sum.first).real(sum.area).integer(sum.held);
    if (auto done = query.run(); !done) return done;
  }
  return {};
}

Result<std::optional<std::int64_t>> Retention::oldest(const char* sql) {
  auto first = store_.database().prepare(sql, kDoing);
  if (!first) return fail(first.error());
  std::optional<std::int64_t> oldest;
  for (const auto& [row, one] : store_.series()) {
    Query query(*first);
    const auto there = query.integer(row).next();
    if (!there) return fail(there.error());
    if (*there) oldest = std::min(oldest.value_or(query.integer_at(0)), query.integer_at(0));
  }
  return oldest;
}

namespace {

constexpr Duration kFirstPause = std::chrono::seconds(1), kMaxPauseTime = std::chrono::minutes(1);
/// After a power failure at most this is missing.
constexpr Duration kSyncEvery = std::chrono::seconds(10);
constexpr Duration kMeasureEvery = std::chrono::minutes(1);

std::optional<std::uint64_t> free_beside(const std::string& path) {
  std::error_code error;
  const auto space = std::filesystem::space(std::filesystem::absolute(path).parent_path(), error);
  return error ? std::nullopt : std::optional<std::uint64_t>(space.available);
}

std::uint64_t size_of(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

}  // namespace

Keeper::Keeper(std::string path, RetentionRules rules) : Keeper(std::move(path), rules, free_beside) {}

Error Keeper::why() const {
  return {ErrorCode::kIo, reason_.empty() ? fmt::format("history {}: not open yet", path_) : reason_};
}

Keeper::Report Keeper::work(Batch batch, SteadyTime now, WallTime wall) {
  now_ = now;
  report_ = Report();
  for (const auto& [slot, declaration] : batch.declared) {
    if (slot >= slots_.size()) slots_.resize(slot + 1);
    slots_[slot] = declaration;
  }
  if (!batch.empty()) waiting_.push_back(std::move(batch));
  try {
    work_due(now, wall);
  } catch (const std::bad_alloc&) {
    close();  // what the store knows may differ from the file now
    failed({ErrorCode::kBusy, fmt::format("history {}: there is not enough memory", path_)});
  }
  for (const auto& one : waiting_) {
    report_.waiting += one.bytes();
    report_.unwritten += one.size();
  }
  report_.reason = reason_;
  report_.bytes = bytes_;
  return std::move(report_);
}

void Keeper::work_due(SteadyTime now, WallTime wall) {
  const bool tries = now >= try_again_;
  if (tries) {
    if (!store_) try_open(wall);
    if (store_) write_waiting(wall);
  }
  // Also after a failure: what retention removes is room on a full disk.
  if (store_ && (tries || reason_.empty())) maintain(now, wall);
}

Keeper::Report Keeper::finish(Batch batch, SteadyTime now, WallTime wall) {
  if (!store_ && waiting_.empty() && batch.empty()) return {};
  try_again_ = now;
  check_ = Check::kHeader;
  auto report = work(std::move(batch), now, wall);
  if (!store_) return report;
  if (auto done = store_->sync(); !done) report.log.emplace_back(base::LogLevel::kWarning, done.error().text);
  return report;
}

Result<std::unique_ptr<Store>> Keeper::open_store() const {
  if (check_ == Check::kHeader) return Store::open(path_, sqlite::FileUse::kOwn, false);
  return Store::open(path_, sqlite::FileUse::kOwn, true, true, ending());
}

void Keeper::close() {
  retention_.reset();
  store_.reset();
}

void Keeper::try_open(WallTime wall) {
  auto opened = open_store();
  std::error_code ignored;
  if (!opened && opened.error().code == ErrorCode::kInvalid && std::filesystem::is_regular_file(path_, ignored)) {
    note(base::LogLevel::kError, opened.error().text);
    set_aside(wall);
    opened = open_store();
  }
  if (!opened) return failed(opened.error());
  if ((*opened)->read_only())
    return failed({ErrorCode::kRefused, fmt::format("history {}: no permission to write", path_)});
  store_ = std::move(*opened);
  retention_ = std::make_unique<Retention>(*store_, rules_);
  bytes_ = size_of(path_);
  measure_ = now_ + kMeasureEvery;
  report_.opened = true;
  for (const auto& [row, one] : store_->series()) report_.series.push_back(one.declaration);
  if (!slots_.empty()) {
    Batch again{wall, {}, {}, {}};
    for (Slot slot = 0; slot < slots_.size(); ++slot) again.declared.emplace_back(slot, slots_[slot]);
    waiting_.push_front(std::move(again));
  }
}

void Keeper::set_aside(WallTime wall) {
  close();
  const auto moved = sqlite::set_aside(kNoun, path_, wall);
  if (moved) {
    note(base::LogLevel::kError, fmt::format("history {}: damaged; it is {} now, and a new one begins", path_, *moved));
  } else {
    failed(moved.error());
  }
}

void Keeper::write_waiting(WallTime wall) {
  auto done = write_in_order();
  for (const bool is_checked : {false, true}) {
    if (done || done.error().code != ErrorCode::kInvalid) break;
    note(base::LogLevel::kError, done.error().text);
    // Opening it checks it. The check does not find all damage (https://www.sqlite.org/pragma.html, "quick_check").
    if (is_checked && !store_->database().damaged()) break;
    if (is_checked) {
      set_aside(wall);
    } else {
      close();
    }
    try_open(wall);
    if (!store_) return;
    done = write_in_order();
  }
  if (!done) return failed(done.error());
  pause_ = {};
  if (!std::exchange(reason_, {}).empty())
    note(base::LogLevel::kInfo, fmt::format("history {}: points are written again", path_));
}

/// Writes the batches that wait, until one fails; also if all were dropped.
Result<void> Keeper::write_in_order() {
  Result<void> done;
  for (; !waiting_.empty(); waiting_.pop_front()) {
    const auto& next = waiting_.front();
    done = store_->write(next);
    if (done) {
      report_.points += next.size();
      unsynced_ = true;
      continue;
    }
    const auto code = done.error().code;
    if (code != ErrorCode::kOutOfRange && code != ErrorCode::kDuplicate) break;  // another time, perhaps
    report_.dropped += next.size();
    note(base::LogLevel::kError, fmt::format("{}; {} points are dropped", done.error().text, next.size()));
  }
  return done;
}

void Keeper::failed(const Error& error) {
  ++report_.failures;
  pause_ = std::clamp<Duration>(2 * pause_, kFirstPause, kMaxPauseTime);
  try_again_ = now_ + pause_;
  if (std::exchange(reason_, error.text) != error.text && !ending().stop_requested())
    note(base::LogLevel::kError, error.text + "; points wait until it can be written");
}

void Keeper::maintain(SteadyTime now, WallTime wall) {
  if (unsynced_ && now >= sync_) {
    sync_ = now + kSyncEvery;
    unsynced_ = false;
    if (auto done = store_->sync(); !done) note(base::LogLevel::kWarning, done.error().text);
  }
  const auto said = retention_->step(now, wall, free_(path_));
  if (!said) {
    ++report_.failures;
    note(base::LogLevel::kWarning, said.error().text);
  } else if (!said->empty()) {
    note(base::LogLevel::kWarning, *said);
  }
  if (now < measure_) return;
  measure_ = now + kMeasureEvery;
  bytes_ = size_of(path_);
}

}  // namespace rubicon::history
