#include "history/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <tuple>

#include "base/assert.h"
#include "history/buckets.h"
#include "sqlite/database.h"

namespace rubicon::history {

using sqlite::Query;

namespace {

/// Blocks that one batch closes because of their age: many series that began together do not close together.
constexpr std::size_t kAgedAtOnce = 100;
constexpr std::size_t kSearchedAtOnce = 2000;
/// A block with fewer points is joined with the next one of its series.
constexpr std::size_t kSmallBlock = 512;
constexpr unsigned kTrimEvery = 60;
/// The journal's rows have about as many bytes at most, before they are packed.
constexpr std::size_t kJournalRow = 1 << 20;

/// The first blocks of series that began together end apart.
std::size_t first_limit(SeriesRow row) {
  return kBlockPoints / 2 + static_cast<std::size_t>(row * 2654435761LL >> 7) % (kBlockPoints / 2);
}

}  // namespace

/// One batch on its way into the file.
struct Store::Writing {
  std::map<SeriesRow, Points> points;  ///< new ones
  struct Closing {
    std::vector<Points> blocks;
    Points rest;
  };
  std::map<SeriesRow, Closing> closing;
  std::vector<Slot> resolved;                                     ///< slots whose row is new in this transaction
  std::vector<std::pair<SeriesRow, Declaration>> new_or_changed;  ///< series
  std::int64_t journal = 0, next_journal = 0;                     ///< its first row, and that after the last
  SeriesRow next_aged = 0;
};

Result<std::unique_ptr<Store>> Store::open(const std::string& path, sqlite::FileUse use, bool thorough, bool create,
                                           const std::stop_token& stop) {
  auto file = open_history_file(path, use, thorough, create, stop);
  if (!file) return fail(file.error());
  std::unique_ptr<Store> store(new Store(std::move(*file)));
  const sqlite::Interruption interruption(store->file_.database, {}, stop);
  auto done = store->prepare();
  if (done) return store;
  // The owner may repair a sound file whose tables are not the ones of this program.
  const bool unfit = done.error().code == ErrorCode::kInvalid && !store->database().damaged();
  return fail(unfit ? ErrorCode::kRefused : done.error().code, done.error().text);
}

Result<void> Store::prepare() {
  // A block that is closed later must not be read beside the journal of before.
  if (read_only()) {
    if (auto done = file_.database.run("BEGIN", "opening"); !done) return done;
  }
  const auto version = file_.database.number("PRAGMA user_version", "opening");
  if (!version) return fail(version.error());
  has_areas_ = *version >= kAreasSince;
  if (auto done = prepare_statements(file_.database, sql_, has_areas_); !done) return done;
  const auto alive = meta("alive");
  if (!alive) return fail(alive.error());
  alive_ = alive->value_or(0);
  if (auto done = load_series(); !done) return done;
  if (auto done = replay_journal(); !done) return done;
  if (!read_only()) mark_gaps();
  return {};
}

Result<void> Store::load_series() {
  auto statement = file_.database.prepare("SELECT id,owner,key,kind,unit,words FROM series", "reading its series");
  if (!statement) return fail(statement.error());
  Query query(*statement);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return {};
    Series one;
    one.declaration.name = {OwnerId(static_cast<std::uint32_t>(query.integer_at(1))), std::string(query.text_at(2))};
    one.declaration.kind = static_cast<SeriesKind>(std::clamp<std::int64_t>(query.integer_at(3), 0, 2));
    one.declaration.unit = query.text_at(4);
    one.declaration.words = words_from_text(query.text_at(5));
    one.next_limit = first_limit(query.integer_at(0));
    names_.emplace(one.declaration.name, query.integer_at(0));
    series_.emplace(query.integer_at(0), std::move(one));
  }
}

Result<void> Store::replay_journal() {
  auto statement = file_.database.prepare("SELECT id,time,data FROM journal ORDER BY id", "reading its journal");
  if (!statement) return fail(statement.error());
  Query query(*statement);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return {};
    next_journal_ = query.integer_at(0) + 1;
    alive_ = std::max(alive_, query.integer_at(1));
    replay(query.integer_at(0), query.blob_at(2));
  }
}

/// The row is a list of: row of a series, length, packed points. Length 0: all points of the series so far are in
/// blocks.
void Store::replay(std::int64_t row, ByteView data) {
  const auto plain = codec_.open(data);
  if (!plain) return count_damage();
  NumberReader reader(*plain);
  while (reader.ok() && reader.remaining() > 0) {
    const auto id = static_cast<SeriesRow>(reader.number());
    const auto packed = reader.take(reader.number());
    if (!reader.ok()) return count_damage();
    const auto found = series_.find(id);
    if (found == series_.end()) continue;  // it was removed since, with all its points
    auto& one = found->second;
    if (packed.empty()) {
      one.open.clear();
      continue;
    }
    const auto points = unpack_points(packed);
    if (!points) return count_damage();
    if (one.open.empty()) one.first_journal = row;
    for (const auto& point : *points) one.open.add(point);
  }
}

/// The process before this one ended: what came after its last batch was not observed.
void Store::mark_gaps() {
  for (const auto& [row, one] : series_) {
    if (one.open.empty() || one.open.last().gap()) continue;
    const auto last = one.open.last().time;
    // Values with times of long ago, as of a recording, were not observed then.
    const bool live = std::abs(alive_ - last) <= kOpenBlock;
    marks_.emplace_back(row, Point{live ? std::max(alive_, last) + 1 : last + 1, kGap});
  }
}

std::optional<SeriesRow> Store::find(const SeriesName& name) const {
  const auto found = names_.find(name);
  return found == names_.end() ? std::nullopt : std::optional(found->second);
}

Result<void> Store::transact(const std::function<Result<void>()>& work) {
  if (auto done = file_.database.run("BEGIN IMMEDIATE", "beginning to write"); !done) return done;
  Result<void> done;
  try {
    done = work();
  } catch (const std::bad_alloc&) {
    done = fail(ErrorCode::kBusy, fmt::format("{} {}: writing: there is not enough memory", kNoun, path()));
  }
  if (done) done = file_.database.run("COMMIT", "writing");
  // SQLite has already undone it if the disk is full.
  if (!done && file_.database.in_transaction()) std::ignore = file_.database.run("ROLLBACK", "rolling back");
  return done;
}

Result<void> Store::write(const Batch& batch) {
  for (const auto& [slot, declaration] : batch.declared) {
    if (slot >= slots_.size()) slots_.resize(slot + 1);
    if (slots_[slot].declaration == declaration) continue;
    slots_[slot] = {declaration, 0};  // the row is looked up, and brought up to date, with the next point
  }
  Writing writing;
  const auto now = to_milliseconds(batch.time);
  auto done = transact([&] { return write_rows(batch, writing); });
  if (done) {
    apply(writing, now);
  } else {
    for (const auto slot : writing.resolved) slots_[slot].row = 0;
  }
  return done;
}

Result<void> Store::write_rows(const Batch& batch, Writing& writing) {
  for (const auto& [row, mark] : marks_) writing.points[row].push_back(mark);
  const auto resolve = [&](Slot slot) -> Result<SeriesRow> {
    RUBICON_ASSERT(slot < slots_.size());
    auto& state = slots_[slot];
    if (state.row != 0) return state.row;
    const auto row = put_series(state.declaration, writing);
    if (!row) return row;
    state.row = *row;
    writing.resolved.push_back(slot);
    return row;
  };
  for (const auto& [slot, point] : batch.points) {
    const auto row = resolve(slot);
    if (!row) return fail(row.error());
    writing.points[*row].push_back(point);
  }
  for (const auto& text : batch.texts) {
    const auto row = resolve(text.slot);
    if (!row) return fail(row.error());
    if (auto done = Query(sql_.insert_text).integer(*row).integer(text.time).text(text.text).run(); !done) return done;
  }
  const auto now = to_milliseconds(batch.time);
  plan(writing, now);
  for (auto& [row, closing] : writing.closing) {
    for (auto& points : closing.blocks) {
      if (auto done = write_block(row, std::move(points)); !done) return done;
    }
  }
  if (auto done = write_journal(writing, batch.time); !done) return done;
  if (++writes_ % kTrimEvery == 0) return trim_journal();
  return {};
}

Result<SeriesRow> Store::put_series(const Declaration& declaration, Writing& writing) {
  const auto words = words_to_text(declaration.words);
  const auto known = find(declaration.name);
  if (!known) {
    Query query(sql_.insert_series);
    query.integer(number(declaration.name.owner)).text(declaration.name.key);
    query.integer(static_cast<int>(declaration.kind)).text(declaration.unit).text(words);
    if (auto done = query.run(); !done) return fail(done.error());
    writing.new_or_changed.emplace_back(query.last_row(), declaration);
    return query.last_row();
  }
  const auto& now = series_.at(*known).declaration;
  if (now == declaration) return *known;
  Query query(sql_.update_series);
  query.integer(static_cast<int>(declaration.kind)).text(declaration.unit).text(words).integer(*known);
  if (auto done = query.run(); !done) return fail(done.error());
  writing.new_or_changed.emplace_back(*known, declaration);
  return *known;
}

/// Which series close blocks: those that would have too many points, or span too much time.
void Store::plan(Writing& writing, std::int64_t now) {
  for (const auto& [row, points] : writing.points) {
    const auto known = series_.find(row);
    const bool fresh = known == series_.end();
    const auto limit = fresh ? first_limit(row) : known->second.next_limit;
    auto start = fresh || known->second.open.empty() ? points.front().time : known->second.open.start();
    auto end = fresh || known->second.open.empty() ? start : known->second.open.end();
    for (const auto& point : points) {
      start = std::min(start, point.time);
      end = std::max(end, point.time);
    }
    const auto count = points.size() + (fresh ? 0 : known->second.open.size());
    if (count < limit && end - start <= kOpenBlock) continue;
    auto all = fresh ? Points() : known->second.open.all();
    all.insert(all.end(), points.begin(), points.end());
    auto blocks = take_blocks(all, limit);
    writing.closing[row] = {std::move(blocks), std::move(all)};
  }
  plan_aged(writing, now);
}

/// And those whose points wait for others that do not come.
void Store::plan_aged(Writing& writing, std::int64_t now) {
  auto next = series_.lower_bound(next_aged_);
  std::size_t closed = 0;
  for (std::size_t i = 0; i < kSearchedAtOnce && closed < kAgedAtOnce && next != series_.end(); ++i, ++next) {
    const auto& open = next->second.open;
    const bool aged = !open.empty() && (now - open.start() > kOpenBlock || open.start() - now > kOpenBlock);
    // One with new points has its turn in a later batch.
    if (!aged || writing.closing.contains(next->first) || writing.points.contains(next->first)) continue;
    writing.closing[next->first] = {{open.all()}, {}};
    ++closed;
  }
  writing.next_aged = next == series_.end() ? 0 : next->first;
}

Result<void> Store::write_block(SeriesRow row, Points points) {
  const auto earlier = [](const Point& a, const Point& b) { return a.time < b.time; };
  if (!std::is_sorted(points.begin(), points.end(), earlier)) std::stable_sort(points.begin(), points.end(), earlier);
  const auto joined = join_last(row, points);
  if (!joined) return fail(joined.error());
  return insert_block(row, points);
}

/// Takes the last block of the series back into `points` if both are small: a slow series would otherwise have many
/// blocks of few points.
Result<bool> Store::join_last(SeriesRow row, Points& points) {
  Query query(sql_.last_block);
  const auto there = query.integer(row).next();
  if (!there) return fail(there.error());
  if (!*there) return false;
  const auto start = query.integer_at(0), part = query.integer_at(1), end = query.integer_at(2);
  const auto count = query.integer_at(3) + query.integer_at(4);
  const bool small = count < static_cast<std::int64_t>(kSmallBlock) && points.size() < kSmallBlock;
  if (!small || end > points.front().time || points.back().time - start > kMaxBlockLength) return false;
  auto before = codec_.decode(query.blob_at(5));
  if (!before) {
    count_damage();
    return false;
  }
  before->insert(before->end(), points.begin(), points.end());
  points = std::move(*before);
  if (auto done = Query(sql_.delete_block).integer(row).integer(start).integer(part).run(); !done)
    return fail(done.error());
  return true;
}

Result<void> Store::insert_block(SeriesRow row, const Points& points) {
  Summed sum;
  const auto start = points.front().time;
  std::int64_t gaps = 0;
  for (const auto& point : points) {
    if (point.gap()) {
      ++gaps;
    } else {
      sum.add(point.time, point.value);
    }
  }
  each_hold(points, [&](double value, std::int64_t from, std::int64_t until) { sum.hold(value, until - from); });
  Query part(sql_.next_part);
  if (const auto there = part.integer(row).integer(start).next(); !there) return fail(there.error());
  const auto data = codec_.encode(points);
  Query query(sql_.insert_block);
  query.integer(row)
      .integer(start)
      .integer(part.integer_at(0))
      .integer(points.back().time)
      .integer(sum.count)
      .integer(gaps);
  query.real(sum.minimum).real(sum.maximum).real(sum.sum).real(sum.last).blob(data);
  query.real(sum.first).real(sum.area).integer(sum.held);
  return query.run();
}

Result<void> Store::write_journal(Writing& writing, WallTime time) {
  writing.journal = writing.next_journal = next_journal_;
  Bytes plain;
  const auto put = [&](SeriesRow row, ByteView packed) -> Result<void> {
    put_number(plain, static_cast<std::uint64_t>(row));
    put_number(plain, packed.size());
    plain.insert(plain.end(), packed.begin(), packed.end());
    if (plain.size() < kJournalRow) return {};
    auto done = insert_journal(writing.next_journal++, time, plain);
    plain.clear();
    return done;
  };
  for (const auto& [row, closing] : writing.closing) {
    auto done = put(row, {});
    if (done && !closing.rest.empty()) done = put(row, pack_points(closing.rest));
    if (!done) return done;
  }
  for (const auto& [row, points] : writing.points) {
    if (writing.closing.contains(row)) continue;
    if (auto done = put(row, pack_points(points)); !done) return done;
  }
  const bool first = writing.next_journal == writing.journal;  // a batch has a row also without points: its time
  return first || !plain.empty() ? insert_journal(writing.next_journal++, time, plain) : Result<void>();
}

Result<void> Store::insert_journal(std::int64_t row, WallTime time, ByteView plain) {
  const auto data = codec_.close(plain);
  return Query(sql_.insert_journal).integer(row).integer(to_milliseconds(time)).blob(data).run();
}

Result<void> Store::trim_journal() {
  auto first = next_journal_;
  for (const auto& [row, one] : series_) {
    if (!one.open.empty()) first = std::min(first, one.first_journal);
  }
  if (auto done = Query(sql_.trim_journal).integer(first).run(); !done) return done;
  return put_meta("alive", alive_);
}

/// The transaction is in the file: the memory follows.
void Store::apply(Writing& writing, std::int64_t now) {
  marks_.clear();
  alive_ = std::max(alive_, now);
  next_journal_ = writing.next_journal;
  next_aged_ = writing.next_aged;
  for (auto& [row, declaration] : writing.new_or_changed) {
    const auto [known, fresh] = series_.try_emplace(row);
    if (fresh) known->second.next_limit = first_limit(row);
    known->second.declaration = declaration;
    names_.insert_or_assign(std::move(declaration.name), row);
  }
  for (auto& [row, closing] : writing.closing) {
    auto& one = series_.at(row);
    one.open.clear();
    one.next_limit = kBlockPoints;
    one.first_journal = writing.journal;
    for (const auto& point : closing.rest) one.open.add(point);
  }
  for (const auto& [row, points] : writing.points) {
    if (writing.closing.contains(row)) continue;
    auto& one = series_.at(row);
    if (one.open.empty()) one.first_journal = writing.journal;
    for (const auto& point : points) one.open.add(point);
  }
}

Result<void> Store::close_all() {
  auto done = transact([&]() -> Result<void> {
    for (const auto& [row, one] : series_) {
      if (one.open.empty()) continue;
      if (auto written = write_block(row, one.open.all()); !written) return written;
    }
    if (auto kept = put_meta("alive", alive_); !kept) return kept;
    return file_.database.run("DELETE FROM journal", "closing its blocks");
  });
  if (!done) return done;
  for (auto& [row, one] : series_) one.open.clear();
  next_journal_ = 1;
  return {};
}

Result<void> Store::sync() {
  return file_.database.sync();
}

}  // namespace rubicon::history
