#include "history/retention.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "history/buckets.h"

namespace rubicon::history {

using sqlite::Query;

namespace {

constexpr Duration kRoundEvery = std::chrono::hours(1);
constexpr Duration kLargeEvery = std::chrono::minutes(1);  // a look at the size
constexpr int kFastest = 4;                                // clock of the machine : time that passed
constexpr std::size_t kSeriesAtOnce = 100;
constexpr int kBlocksAtOnce = 50;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 4;
constexpr const char* kDoing = "removing what is old";

}  // namespace

Result<void> Retention::advance(SteadyTime now, WallTime wall) {
  if (!started_) {
    const auto kept = store_.meta("clock");
    if (!kept) return fail(kept.error());
    clock_ = *kept ? std::min(from_milliseconds(**kept), wall) : wall;
    last_ = now;
    next_round_ = now;
    started_ = true;
    return {};
  }
  const auto reachable = clock_ + std::chrono::duration_cast<std::chrono::microseconds>(kFastest * (now - last_));
  clock_ = std::min(wall, reachable);
  last_ = now;
  return {};
}

Result<std::string> Retention::step(SteadyTime now, WallTime wall) {
  if (auto done = advance(now, wall); !done) return fail(done.error());
  std::string said;
  if (!in_round_) {
    if (now < next_round_) return said;
    auto begun = begin_round();
    if (!begun) return begun;
    said = std::move(*begun);
    next_round_ = now + (shrinking_ ? kLargeEvery : kRoundEvery);
  }
  auto done = store_.transact([this] { return slice(); });
  if (!done) return fail(done.error());
  return said;
}

Result<std::string> Retention::begin_round() {
  in_round_ = true;
  next_row_ = 0;
  const auto clock = to_milliseconds(clock_);
  blocks_before_ = rules_.raw ? floor_to(clock - milliseconds(*rules_.raw), kHour) : kNever;
  hours_before_ = rules_.hours ? clock - milliseconds(*rules_.hours) : kNever;
  shrinking_ = false;
  if (auto done = store_.put_meta("clock", clock); !done) return fail(done.error());
  const auto used = used_bytes();
  if (!used) return fail(used.error());
  if (*used <= rules_.size) return std::string();
  const auto oldest = oldest_block();
  if (!oldest) return fail(oldest.error());
  shrinking_ = true;
  const auto what = fmt::format("{}: larger than {} bytes", store_.path(), rules_.size);
  if (!*oldest) {
    hours_before_ = kFurthest;  // no block is left: the summaries are too many
    return what + ": the summaries of hours go";
  }
  blocks_before_ = std::max(blocks_before_, floor_to(**oldest, kDay) + kDay);
  return fmt::format("{}: the points before {:%Y-%m-%d} go", what,
                     fmt::gmtime(std::chrono::floor<std::chrono::seconds>(from_milliseconds(blocks_before_))));
}

Result<void> Retention::slice() {
  auto next = store_.series().lower_bound(next_row_);
  std::vector<SeriesRow> empty;
  for (std::size_t i = 0; i < kSeriesAtOnce && next != store_.series().end(); ++i) {
    const auto row = next->first;
    const auto more = slice_of(row);
    if (!more) return fail(more.error());
    next_row_ = row;
    if (*more) return {};  // the rest of this series in the next slice
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
  {
    Query query(*blocks);
    query.integer(row).integer(blocks_before_).integer(blocks_before_).integer(kBlocksAtOnce);
    while (true) {
      const auto there = query.next();
      if (!there) return fail(there.error());
      if (!*there) break;
      gone.emplace_back(query.integer_at(0), query.integer_at(1));
      const auto points = store_.codec().decode(query.blob_at(2));
      if (!points) {
        store_.count_damage();
      } else if (auto done = keep_hours(row, *points); !done) {
        return fail(done.error());
      }
    }
  }
  auto remove = database.prepare("DELETE FROM block WHERE series=? AND start=? AND part=?", kDoing);
  if (!remove) return fail(remove.error());
  for (const auto& [start, part] : gone) {
    if (auto done = Query(*remove).integer(row).integer(start).integer(part).run(); !done) return fail(done.error());
  }
  if (gone.size() == kBlocksAtOnce) return true;
  for (const auto& [sql, before] : {std::pair{"DELETE FROM hour WHERE series=? AND start<?", hours_before_},
                                    std::pair{"DELETE FROM text WHERE series=? AND time<?", blocks_before_}}) {
    auto old = database.prepare(sql, kDoing);
    if (!old) return fail(old.error());
    if (auto done = Query(*old).integer(row).integer(before).run(); !done) return fail(done.error());
  }
  return false;
}

Result<void> Retention::keep_hours(SeriesRow row, const Points& points) {
  std::map<std::int64_t, Summed> hours;
  auto sorted = points;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Point& a, const Point& b) { return a.time < b.time; });
  for (const auto& point : sorted) {
    const auto hour = floor_to(point.time, kHour);
    if (!point.gap() && hour >= hours_before_) hours[hour].add(point.time, point.value);
  }
  auto put = store_.database().prepare(
      "INSERT INTO hour VALUES(?1,?2,?3,?4,?5,?6,?7,?8) ON CONFLICT DO UPDATE SET until=max(until,?3),count=count+?4,"
      "minimum=min(minimum,?5),maximum=max(maximum,?6),sum=sum+?7,last=CASE WHEN ?3>=until THEN ?8 ELSE last END",
      "summing up an hour");
  if (!put) return fail(put.error());
  for (const auto& [hour, sum] : hours) {
    Query query(*put);
    query.integer(row).integer(hour).integer(sum.end).integer(sum.count);
    query.real(sum.minimum).real(sum.maximum).real(sum.sum).real(sum.last);
    if (auto done = query.run(); !done) return done;
  }
  return {};
}

Result<std::uint64_t> Retention::used_bytes() {
  auto& database = store_.database();
  const auto pages = database.number("PRAGMA page_count", "measuring");
  const auto unused = database.number("PRAGMA freelist_count", "measuring");
  const auto size = database.number("PRAGMA page_size", "measuring");
  for (const auto* one : {&pages, &unused, &size}) {
    if (!*one) return fail(one->error());
  }
  return static_cast<std::uint64_t>(std::max<std::int64_t>(*pages - *unused, 0) * *size);
}

Result<std::optional<std::int64_t>> Retention::oldest_block() {
  auto first = store_.database().prepare("SELECT until FROM block WHERE series=? ORDER BY start LIMIT 1", kDoing);
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

}  // namespace rubicon::history
