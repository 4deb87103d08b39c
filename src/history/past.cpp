#include "history/past.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/compare_text.h"
#include "history/history_source.h"

namespace rubicon::history {

using sqlite::Query;
using sqlite::Statement;

namespace {

constexpr const char* kReading = "reading the past";
/// Milliseconds from 1970: the buckets of a question, which may begin before and end after it, are within kFurthest.
constexpr std::int64_t kFurthestAsked = kFurthest / 9;

/// Blocks whose times overlap; most stand alone.
class Overlapping {
 public:
  using Visit = std::function<bool(const Point&)>;

  struct Block {
    Summed sum;  ///< start and end include gaps
    std::int64_t gaps = 0;
    Bytes data;
  };

  bool touches(std::int64_t start) const { return !blocks_.empty() && start <= end_; }
  void add(Block block) {
    end_ = blocks_.empty() ? block.sum.end : std::max(end_, block.sum.end);
    blocks_.push_back(std::move(block));
  }
  void clear() { blocks_.clear(); }
  const std::vector<Block>& blocks() const { return blocks_; }

  /// All points by time; those of damaged blocks are missing and counted.
  Points points(Store& store) const {
    Points all;
    for (const auto& block : blocks_) {
      const auto some = store.codec().decode(block.data);
      const auto within = [&](const Point& point) {
        return point.time >= block.sum.start && point.time <= block.sum.end;
      };
      if (some && std::all_of(some->begin(), some->end(), within)) {
        all.insert(all.end(), some->begin(), some->end());
      } else {
        store.count_damage();
      }
    }
    sort(all);
    return all;
  }

  static void sort(Points& points) {
    const auto earlier = [](const Point& a, const Point& b) { return a.time < b.time; };
    if (!std::is_sorted(points.begin(), points.end(), earlier)) std::stable_sort(points.begin(), points.end(), earlier);
  }

 private:
  std::vector<Block> blocks_;
  std::int64_t end_ = 0;
};

Overlapping::Block block_at(const Query& query) {
  Overlapping::Block block;
  block.sum.start = query.integer_at(0);
  block.sum.end = query.integer_at(1);
  block.sum.count = static_cast<std::uint32_t>(query.integer_at(2));
  block.gaps = query.integer_at(3);
  block.sum.minimum = query.real_at(4);
  block.sum.maximum = query.real_at(5);
  block.sum.sum = query.real_at(6);
  block.sum.last = query.real_at(7);
  block.sum.first = query.real_at(9);
  block.sum.area = query.real_at(10);
  // Within its bounds also in a damaged file; less than 0 = unknown.
  block.sum.held = std::clamp<std::int64_t>(query.integer_at(11), -1, kMaxBlockLength);
  const auto data = query.blob_at(8);
  block.data.assign(data.begin(), data.end());
  return block;
}

/// Calls `flush` with groups of blocks that touch [from, to), by time; the open points are one of the blocks.
Result<void> each_group(Store& store, SeriesRow row, std::int64_t from, std::int64_t to,
                        const std::function<bool(const Overlapping&)>& flush) {
  auto statement = store.database().prepare(
      fmt::format("SELECT start,until,count,gaps,minimum,maximum,sum,last,data,{} FROM block WHERE series=? AND "
                  "start>=? AND start<? AND until>=? ORDER BY start,part",
                  store.has_areas() ? "first,area,coalesce(held,-1)" : "0,0,-1")
          .c_str(),
      kReading);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  query.integer(row).integer(std::max(from, -kFurthest) - kMaxBlockLength).integer(to).integer(from);
  const auto& open = store.series().at(row).open;
  bool open_waits = !open.empty() && open.start() < to && open.end() >= from;
  Overlapping group;
  const auto take = [&](Overlapping::Block block) {
    const bool alone = !group.touches(block.sum.start);
    if (alone && !group.blocks().empty() && !flush(group)) return false;
    if (alone) group.clear();
    group.add(std::move(block));
    return true;
  };
  const auto take_open = [&] {
    open_waits = false;
    Overlapping::Block block;
    block.sum.start = open.start();
    block.sum.end = open.end();
    block.gaps = -1;  // not counted: its points are looked at
    block.data = store.codec().encode(open.all());
    return take(std::move(block));
  };
  while (true) {
    const auto there = query.next();
    if (!there) return fail(there.error());
    if (!*there) break;
    if (open_waits && query.integer_at(0) >= open.start() && !take_open()) return {};
    if (!take(block_at(query))) return {};
  }
  if (open_waits && !take_open()) return {};
  if (!group.blocks().empty()) flush(group);
  return {};
}

/// The last point before `time` that is in a block or open.
Result<std::optional<Point>> point_before(Store& store, SeriesRow row, std::int64_t time) {
  std::optional<Point> before;
  const auto look = [&](const Points& points) {
    for (const auto& point : points) {
      if (point.time < time && (!before || point.time >= before->time)) before = point;
    }
  };
  auto statement = store.database().prepare(
      "SELECT data FROM block WHERE series=? AND start<? AND start>=? ORDER BY start DESC,part DESC LIMIT 2", kReading);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  query.integer(row).integer(time).integer(time - kMaxBlockLength - kSilence);
  while (true) {
    const auto there = query.next();
    if (!there) return fail(there.error());
    if (!*there) break;
    if (const auto points = store.codec().decode(query.blob_at(0))) look(*points);
  }
  const auto& open = store.series().at(row).open;
  if (!open.empty() && open.start() < time) look(open.all());
  return before;
}

/// Hours that only have a summary.
Result<void> collect_hours(Store& store, SeriesRow row, const Grid& grid, Collector& collector) {
  // Earlier releases did not keep this value: the mean replaces it.
  auto statement = store.database().prepare(
      fmt::format("SELECT start,until,count,minimum,maximum,sum,last,{} FROM hour WHERE series=? AND start>=? AND "
                  "start<? ORDER BY start",
                  store.has_areas() ? "coalesce(first,sum/count),coalesce(area,sum/count*(until-start)),"
                                      "coalesce(held,until-start)"
                                    : "sum/count,sum/count*(until-start),until-start")
          .c_str(),
      kReading);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  query.integer(row).integer(grid.from).integer(grid.to);
  while (true) {
    const auto there = query.next();
    if (!there) return fail(there.error());
    if (!*there) return {};
    const auto start = query.integer_at(0);
    const auto end = std::clamp(query.integer_at(1), start, start + kHour);  // also of a damaged file
    collector.add(Summed{start, end, static_cast<std::uint32_t>(query.integer_at(2)), query.real_at(7),
                         query.real_at(3), query.real_at(4), query.real_at(5), query.real_at(6), query.real_at(8),
                         std::clamp<std::int64_t>(query.integer_at(9), 0, kHour)});
  }
}

/// A block that lies in one bucket and has no gap, not even an unmarked one, need not be unpacked, unless an earlier
/// release wrote it.
bool as_one(const Overlapping& group, const Grid& grid) {
  if (group.blocks().size() != 1 || group.blocks()[0].gaps != 0 || group.blocks()[0].sum.held < 0) return false;
  const auto& sum = group.blocks()[0].sum;
  if (!grid.contains(sum.start) || !grid.contains(sum.end) || sum.end - sum.start > kSilence) return false;
  return sum.count > 0 && grid.place(sum.start) == grid.place(sum.end);
}

Result<void> collect(Store& store, SeriesRow row, const Grid& grid, SeriesAnswer& out) {
  const auto before = point_before(store, row, grid.from);
  if (!before) return fail(before.error());
  Collector collector(grid, *before, store.alive());
  if (auto done = collect_hours(store, row, grid, collector); !done) return done;
  auto done = each_group(store, row, grid.from, grid.to, [&](const Overlapping& group) {
    if (as_one(group, grid)) {
      collector.add(group.blocks()[0].sum);
    } else {
      for (const auto& point : group.points(store)) collector.add(point);
    }
    return true;
  });
  collector.finish(out);
  return done;
}

Result<void> find_text_before(Store& store, SeriesRow row, const Grid& grid, SeriesAnswer& out) {
  auto statement = store.database().prepare(
      "SELECT time,value FROM text WHERE series=? AND time<? ORDER BY time DESC LIMIT 1", kReading);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  const auto there = query.integer(row).integer(grid.from).next();
  if (!there) return fail(there.error());
  if (!*there || query.text_at(1).empty()) return {};
  out.text_before = TextValue{from_milliseconds(query.integer_at(0)), std::string(query.text_at(1))};
  return {};
}

/// The newest ones first, as many as were asked for and as `budget` (bytes) has room for.
Result<void> collect_texts(Store& store, SeriesRow row, const Grid& grid, std::size_t most, std::size_t& budget,
                           SeriesAnswer& out) {
  if (auto done = find_text_before(store, row, grid, out); !done) return done;
  auto statement = store.database().prepare(
      "SELECT time,value FROM text WHERE series=? AND time>=? AND time<? ORDER BY time DESC LIMIT ?", kReading);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  query.integer(row).integer(grid.from).integer(grid.to).integer(static_cast<std::int64_t>(most));
  while (true) {
    const auto there = query.next();
    if (!there) return fail(there.error());
    if (!*there) break;
    const auto text = query.text_at(1);
    const auto bytes = kTextBytes + text.size();
    if (bytes > budget) break;
    budget -= bytes;
    out.texts.push_back({from_milliseconds(query.integer_at(0)), std::string(text)});
  }
  std::reverse(out.texts.begin(), out.texts.end());
  return {};
}

Result<void> check(const Question& question) {
  const auto invalid = [](std::string text) { return fail(ErrorCode::kInvalid, "history: " + text); };
  if (question.series.empty() || question.series.size() > kMaxAsked)
    return invalid(fmt::format("{} series asked for, expected 1 to {}", question.series.size(), kMaxAsked));
  if (question.buckets == 0 || question.buckets > kMaxBuckets)
    return invalid(fmt::format("{} buckets asked for, expected 1 to {}", question.buckets, kMaxBuckets));
  if (question.from >= question.to) return invalid("the end of the time asked for is not after its beginning");
  if (to_milliseconds(question.from) < -kFurthestAsked || to_milliseconds(question.to) > kFurthestAsked)
    return invalid("the time asked for is out of range");
  return {};
}

/// Statements that find the first and the last time of a series.
Result<std::vector<Statement>> time_statements(Store& store) {
  std::vector<Statement> statements;
  for (const auto* sql : {"SELECT start FROM block WHERE series=? ORDER BY start LIMIT 1",
                          "SELECT until FROM block WHERE series=? ORDER BY start DESC LIMIT 1",
                          "SELECT start FROM hour WHERE series=? ORDER BY start LIMIT 1",
                          "SELECT until FROM hour WHERE series=? ORDER BY start DESC LIMIT 1",
                          "SELECT time FROM text WHERE series=? ORDER BY time LIMIT 1",
                          "SELECT time FROM text WHERE series=? ORDER BY time DESC LIMIT 1"}) {
    auto statement = store.database().prepare(sql, kReading);
    if (!statement) return fail(statement.error());
    statements.push_back(std::move(*statement));
  }
  return statements;
}

Result<std::optional<std::int64_t>> time_of(Statement& statement, SeriesRow row) {
  Query query(statement);
  const auto there = query.integer(row).next();
  if (!there) return fail(there.error());
  return *there ? std::optional(query.integer_at(0)) : std::nullopt;
}

Result<void> find_times(Store& store, std::vector<Statement>& statements, SeriesRow row, SeriesEntry& entry) {
  const auto& open = store.series().at(row).open;
  std::optional<std::int64_t> first, last;
  const auto look = [&](std::int64_t time) {
    first = std::min(first.value_or(time), time);
    last = std::max(last.value_or(time), time);
  };
  if (!open.empty()) {
    look(open.start());
    look(open.end());
  }
  for (auto& statement : statements) {
    const auto time = time_of(statement, row);
    if (!time) return fail(time.error());
    if (*time) look(**time);
  }
  if (first) entry.first = from_milliseconds(*first);
  if (last) entry.last = from_milliseconds(*last);
  return {};
}

/// Names and rows of the series that match, those of the range.
std::vector<std::pair<std::string, SeriesRow>> series_in(const Store& store, const Pattern& pattern,
                                                         const SeriesRange& range) {
  std::vector<std::pair<std::string, SeriesRow>> found;
  for (const auto& [row, one] : store.series()) {
    const auto& name = one.declaration.name;
    if (!pattern.matches(name.owner, name.key)) continue;
    auto text = to_string(name);
    if (range.after.empty() || base::natural_less(range.after, text)) found.emplace_back(std::move(text), row);
  }
  const auto most = std::min(found.size(), range.most);
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(most), found.end(),
                    [](const auto& a, const auto& b) { return base::natural_less(a.first, b.first); });
  found.resize(most);
  return found;
}

}  // namespace

Result<Answer> answer(Store& store, const Question& question) {
  if (auto done = check(question); !done) return fail(done.error());
  // A time within a millisecond belongs to the question.
  const auto to = to_milliseconds(question.to + std::chrono::microseconds(999));
  const auto grid = grid_of(to_milliseconds(question.from), to, question.buckets);
  Answer all{from_milliseconds(grid.from), from_milliseconds(grid.to), std::chrono::milliseconds(grid.width), {}};
  const auto share = kMaxTextBytes / question.series.size();
  for (const auto& name : question.series) {
    auto budget = share;
    SeriesAnswer one;
    one.name = name;
    const auto row = store.find(name);
    if (row) {
      const auto& declaration = store.series().at(*row).declaration;
      one.kind = declaration.kind;
      one.unit = declaration.unit;
      one.words = declaration.words;
      auto done = one.kind == SeriesKind::kText ? collect_texts(store, *row, grid, question.buckets, budget, one)
                                                : collect(store, *row, grid, one);
      if (!done) return fail(done.error());
    }
    all.series.push_back(std::move(one));
  }
  return all;
}

Result<std::vector<SeriesEntry>> list_series(Store& store, const Pattern& pattern, const SeriesRange& range) {
  const auto found = series_in(store, pattern, range);
  auto statements = time_statements(store);
  if (!statements) return fail(statements.error());
  std::vector<SeriesEntry> entries;
  for (const auto& [name, row] : found) {
    const auto& declaration = store.series().at(row).declaration;
    SeriesEntry entry{declaration.name, declaration.kind, declaration.unit, declaration.words, {}, {}};
    if (auto done = find_times(store, *statements, row, entry); !done) return fail(done.error());
    entries.push_back(std::move(entry));
  }
  return entries;
}

Result<void> each_point(Store& store, SeriesRow row, std::int64_t from, std::int64_t to,
                        const std::function<bool(const Point&)>& visit) {
  return each_group(store, row, from, to, [&](const Overlapping& group) {
    for (const auto& point : group.points(store)) {
      if (point.time >= from && point.time < to && !visit(point)) return false;
    }
    return true;
  });
}

Result<void> each_text(Store& store, SeriesRow row, std::int64_t from, std::int64_t to,
                       const std::function<bool(const TextValue&)>& visit) {
  auto statement = store.database().prepare(
      "SELECT time,value FROM text WHERE series=? AND time>=? AND time<? ORDER BY time", kReading);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  query.integer(row).integer(from).integer(to);
  while (true) {
    const auto there = query.next();
    if (!there) return fail(there.error());
    if (!*there || !visit({from_milliseconds(query.integer_at(0)), std::string(query.text_at(1))})) return {};
  }
}

}  // namespace rubicon::history
