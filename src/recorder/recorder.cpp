#include "recorder/recorder.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "model/point_keys.h"

namespace rubicon::recorder {

using recording::Record;
using recording::RecordKind;

namespace {

constexpr Duration kFlushEvery = std::chrono::seconds(1);
constexpr Duration kRotateAgain = std::chrono::minutes(1);
constexpr Duration kMaxPauseTime = std::chrono::minutes(1);
/// Tuples of a snapshot that one turn of the loop writes.
constexpr std::size_t kSlice = 1000;
/// Between two log lines with the number of dropped records.
constexpr Duration kCountEvery = std::chrono::seconds(10);

RecordKind kind_of(tuples::EventKind kind) {
  switch (kind) {
    case tuples::EventKind::kSet:
    case tuples::EventKind::kLost: break;
    case tuples::EventKind::kDeleted: return RecordKind::kDeleted;
    case tuples::EventKind::kExpired: return RecordKind::kExpired;
  }
  return RecordKind::kSet;
}

}  // namespace

Recorder::Recorder(config::RecorderSetup setup, Context context)
    : setup_(std::move(setup)),
      context_(std::move(context)),
      log_lines_(model::IslandKey{context_.prefix}.log_lines()),
      log_(context_.log, "recorder " + setup_.name),
      limited_log_(log_, context_.scheduler),
      block_(setup_.compression),
      file_(context_.transports, base::resolve_path(context_.directory, setup_.file),
            {identity(), context_.prefix, {}, "rubicon " RUBICON_VERSION}, setup_.rotation),
      end_turn_(context_.scheduler, [this] { seen_.reset(); }),
      next_slice_(context_.scheduler, [this] { write_snapshot_slice(); }) {}

Recorder::~Recorder() {
  closing_ = true;
  subscriptions_.clear();
  write_block();
}

OwnerId Recorder::identity() const {
  return context_.island == model::kNoOwner ? context_.space.self() : context_.island;
}

void Recorder::start() {
  ensure_open(context_.scheduler.wall_now());
  begin_snapshot(recording::kMarkStart);
  for (std::size_t i = 0; i < setup_.patterns.size(); ++i) {
    const tuples::Flow flow{setup_.minimum, {}, 0, !setup_.active};
    subscriptions_.push_back(context_.space.subscribe(setup_.patterns[i], flow,
                                                      [this, i](const tuples::Event& event) { on_event(i, event); }));
  }
}

void Recorder::on_event(std::size_t pattern, const tuples::Event& event) {
  const auto& tuple = event.tuple;
  if (event.kind == tuples::EventKind::kLost) return;  // only the copy was lost, the tuple may still exist
  if (is_left_out(tuple.key)) return;
  // A tuple that several patterns match is recorded once.
  const auto end = setup_.patterns.begin() + static_cast<std::ptrdiff_t>(pattern);
  if (std::any_of(setup_.patterns.begin(), end, [&](const auto& one) { return one.matches(tuple.owner, tuple.key); }))
    return;
  add(kind_of(event.kind), tuple);
}

void Recorder::add(RecordKind kind, const tuples::TupleView& tuple) {
  write({kind, seen(), tuple.owner, tuple.key, tuple.value, tuple.media_type, tuple.creator, tuple.sequence,
         tuple.write_time, tuple.user_time, tuple.expire_time});
}

void Recorder::mark(std::string_view word) {
  const auto now = seen();
  const auto self = identity();
  write({RecordKind::kMark, now, self, {}, word, "text/plain", self, 0, now, {}, {}});
}

Result<void> Recorder::note(std::string_view text) {
  if (text.size() > kMaxMark)
    return fail(ErrorCode::kInvalid,
                fmt::format("a mark has at most {} bytes, this one has {}", kMaxMark, text.size()));
  if (base::one_line(text) != text) return fail(ErrorCode::kInvalid, "a mark is one line of printable UTF-8");
  mark(text.empty() ? std::string(recording::kMarkOfUser) : fmt::format("{}: {}", recording::kMarkOfUser, text));
  return {};
}

void Recorder::write(const Record& record) {
  const bool first = block_.empty();
  if (!block_.add(record)) {
    ++counters_.dropped;
    return log_failure(fmt::format("{}: too long to be recorded", model::quoted(record.key)));
  }
  if (block_.full()) return write_block();
  if (first) flush_ = context_.scheduler.after(kFlushEvery, [this] { write_block(); });
}

/// The same for all records of a turn.
WallTime Recorder::seen() {
  if (!seen_) {
    seen_ = context_.scheduler.wall_now();
    end_turn_.request();
  }
  return *seen_;
}

void Recorder::write_block() {
  flush_.cancel();
  if (block_.empty()) return;
  const auto count = block_.records();
  const auto last = block_.last();
  if (!ensure_open(block_.first())) {
    block_.clear();
    return drop(count);
  }
  const auto bytes = block_.close();
  if (auto done = file_.append(bytes); !done) {
    failed_to_write(done.error());
    return drop(count);
  }
  written();
  counters_.records += count;
  counters_.bytes += bytes.size();
  if (closing_) return;
  rotate_if_due(last);
  // A snapshot after a gap records the present tuples.
  if (std::exchange(gap_, false)) begin_snapshot(recording::kMarkSnapshot);
}

/// Opens the file unless it is open; false: that failed, or the pause after a failure is not over.
bool Recorder::ensure_open(WallTime first) {
  if (file_.is_open()) return true;
  if (context_.scheduler.now() < try_again_) return false;
  auto opened = file_.open(first);
  if (!opened) {
    failed_to_write(opened.error());
    return false;
  }
  if (opened->is_new) ++counters_.files;
  counters_.cut += opened->cut;
  log_opening(*opened);
  return true;
}

void Recorder::log_opening(const RecordingFile::Opened& opened) {
  if (opened.cut > 0)
    limited_log_.warning(
        "cut", fmt::format("{}: {} damaged bytes at the end of the file were cut off", file_.path(), opened.cut));
  if (opened.is_new) {
    log_.info(fmt::format("{}: a new recording begins", file_.path()));
  } else if (reason_.empty()) {
    limited_log_.info("continues", fmt::format("{}: the recording continues", file_.path()));
  }
}

void Recorder::rotate_if_due(WallTime now) {
  if (in_snapshot_ || context_.scheduler.now() < rotate_again_ || !file_.rotation_due(now)) return;
  if (auto done = file_.rotate(); !done) {
    rotate_again_ = context_.scheduler.now() + kRotateAgain;
    return failed(done.error());
  }
  if (auto done = file_.remove_old(); !done) failed(done.error());
  begin_snapshot(recording::kMarkSnapshot);
}

void Recorder::failed(const Error& why) {
  ++counters_.failures;
  log_failure(why.text);
}

void Recorder::failed_to_write(const Error& why) {
  failed_at_ = context_.scheduler.now();
  pause_ = std::clamp<Duration>(2 * pause_, kFlushEvery, kMaxPauseTime);
  try_again_ = failed_at_ + pause_;
  ++counters_.failures;
  if (reason_.empty()) {
    failing_since_ = failed_at_;
    dropped_before_ = counters_.dropped;
  }
  if (std::exchange(reason_, why.text) == why.text) return;
  if (!limited_log_.error(why.text, fmt::format("{}; records are dropped until it can be written", why.text))) return;
  next_count_ = failed_at_ + kCountEvery;
}

void Recorder::drop(std::uint64_t records) {
  counters_.dropped += records;
  gap_ = true;
  const auto now = context_.scheduler.now();
  if (now < next_count_) return;
  next_count_ = now + kCountEvery;
  log_.warning(fmt::format("{} records dropped in {} s: {}", counters_.dropped - dropped_before_,
                           std::chrono::duration_cast<std::chrono::seconds>(now - failing_since_).count(), reason_));
}

void Recorder::written() {
  const auto now = context_.scheduler.now();
  // A nearly full disk accepts a block now and then: the pauses stay long until a minute had no failure.
  if (now - failed_at_ >= kMaxPauseTime) pause_ = {};
  if (std::exchange(reason_, {}).empty()) return;
  limited_log_.info("resumed",
                    fmt::format("{}: the recording continues; {} records were dropped in {} s", file_.path(),
                                counters_.dropped - dropped_before_,
                                std::chrono::duration_cast<std::chrono::seconds>(now - failing_since_).count()));
}

void Recorder::log_failure(std::string_view text) {
  limited_log_.error("failure",
                     fmt::format("{} ({} records dropped so far, next report in a minute)", text, counters_.dropped));
}

void Recorder::begin_snapshot(std::string_view word) {
  snapshot_.clear();
  for (const auto& pattern : setup_.patterns) {
    context_.space.list(pattern, [this](const tuples::TupleView& tuple) {
      if (!is_left_out(tuple.key)) snapshot_.emplace_back(tuple.owner, tuple.key);
    });
  }
  if (setup_.patterns.size() > 1) {
    std::sort(snapshot_.begin(), snapshot_.end());
    snapshot_.erase(std::unique(snapshot_.begin(), snapshot_.end()), snapshot_.end());
  }
  const bool running = std::exchange(in_snapshot_, true);
  mark(word);
  if (!running) write_snapshot_slice();
}

void Recorder::write_snapshot_slice() {
  for (std::size_t i = 0; i < kSlice && !snapshot_.empty(); ++i) {
    const auto [owner, key] = std::move(snapshot_.back());
    snapshot_.pop_back();
    if (const auto tuple = context_.space.get(owner, key)) add(RecordKind::kPresent, *tuple);
  }
  if (snapshot_.empty()) {
    mark(recording::kMarkComplete);
    write_block();
    if (snapshot_.empty()) {  // otherwise writing the block ended a gap, and a new snapshot has begun
      in_snapshot_ = false;
      std::exchange(snapshot_, {});
      file_.end_snapshot();
      return;
    }
  }
  next_slice_.request();
}

}  // namespace rubicon::recorder
