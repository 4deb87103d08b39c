#include "recorder/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace rubicon::recorder {

using recording::Record;
using recording::RecordKind;

namespace {

constexpr Duration kFlushEvery = std::chrono::seconds(1);
constexpr Duration kRotateAgain = std::chrono::minutes(1);
constexpr Duration kLongestPause = std::chrono::minutes(1);
/// Tuples of a snapshot written in one turn of the loop.
constexpr std::size_t kSlice = 1000;
/// Between two lines of the log that count what is dropped.
constexpr Duration kCountEvery = std::chrono::seconds(10);

std::string resolved(const std::string& path, const std::string& directory) {
  return (std::filesystem::path(directory) / path).string();
}

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

Recorder::Recorder(config::RecorderSetup setup, Place place)
    : setup_(std::move(setup)),
      place_(std::move(place)),
      log_(place_.log, "recorder " + setup_.name),
      block_(setup_.compression),
      file_(place_.transports, resolved(setup_.file, place_.directory),
            {identity(), place_.prefix, {}, "rubicon " RUBICON_VERSION}, setup_.rotation) {}

Recorder::~Recorder() {
  alive_.reset();
  subscriptions_.clear();
  write_block();
}

OwnerId Recorder::identity() const {
  return place_.island == model::kNoOwner ? place_.space.self() : place_.island;
}

void Recorder::start() {
  make_ready(place_.scheduler.wall_now());
  begin_snapshot(recording::kMarkStart);
  for (std::size_t i = 0; i < setup_.patterns.size(); ++i) {
    const tuples::Flow flow{setup_.minimum, {}, 0, !setup_.active};
    subscriptions_.push_back(place_.space.subscribe(setup_.patterns[i], flow,
                                                    [this, i](const tuples::Event& event) { on_event(i, event); }));
  }
}

void Recorder::on_event(std::size_t pattern, const tuples::Event& event) {
  const auto& tuple = event.tuple;
  if (event.kind == tuples::EventKind::kLost) return;  // nobody ended the tuple, only the copy of it went
  // What two patterns match is told twice.
  const auto end = setup_.patterns.begin() + static_cast<std::ptrdiff_t>(pattern);
  if (std::any_of(setup_.patterns.begin(), end, [&](const auto& one) { return one.matches(tuple.owner, tuple.key); }))
    return;
  add(kind_of(event.kind), tuple);
}

void Recorder::add(RecordKind kind, const tuples::TupleView& tuple) {
  take({kind, seen(), tuple.owner, tuple.key, tuple.value, tuple.media_type, tuple.creator, tuple.sequence,
        tuple.write_time, tuple.user_time, tuple.expire_time});
}

void Recorder::mark(std::string_view word) {
  const auto now = seen();
  const auto self = identity();
  take({RecordKind::kMark, now, self, {}, word, "text/plain", self, 0, now, {}, {}});
}

void Recorder::take(const Record& record) {
  const bool first = block_.empty();
  if (!block_.add(record)) {
    ++counters_.dropped;
    return complain(fmt::format("{}: too long to be recorded", model::quoted(record.key)));
  }
  if (block_.full()) return write_block();
  if (first) flush_ = place_.scheduler.after(kFlushEvery, [this] { write_block(); });
}

/// The clock is read once a turn.
WallTime Recorder::seen() {
  if (seen_is_fresh_) return seen_;
  seen_is_fresh_ = true;
  seen_ = place_.scheduler.wall_now();
  place_.scheduler.post([this, alive = std::weak_ptr<bool>(alive_)] {
    if (alive.lock()) seen_is_fresh_ = false;
  });
  return seen_;
}

void Recorder::write_block() {
  flush_.cancel();
  if (block_.empty()) return;
  const auto count = block_.records();
  const auto last = block_.last();
  if (!make_ready(block_.first())) {
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
  if (!alive_) return;
  rotate_if_due(last);
  // After a gap the next snapshot says what is there by now.
  if (std::exchange(gap_, false)) begin_snapshot(recording::kMarkSnapshot);
}

/// The file is open, or it is not its time to be tried again.
bool Recorder::make_ready(WallTime first) {
  if (file_.is_open()) return true;
  if (place_.scheduler.now() < try_again_) return false;
  auto opened = file_.open(first);
  if (!opened) {
    failed_to_write(opened.error());
    return false;
  }
  if (opened->is_new) ++counters_.files;
  counters_.cut += opened->cut;
  const auto now = place_.scheduler.now();
  if (opened->cut > 0 && complaints_.allow("cut", now)) {
    log_.warning(fmt::format("{}: {} bytes behind the last sound record were cut off", file_.path(), opened->cut));
  }
  if (opened->is_new) {
    log_.info(fmt::format("{}: a new recording begins", file_.path()));
  } else if (reason_.empty() && complaints_.allow("goes on", now)) {
    log_.info(fmt::format("{}: the recording goes on", file_.path()));
  }
  return true;
}

void Recorder::rotate_if_due(WallTime now) {
  if (in_snapshot_ || place_.scheduler.now() < rotate_again_ || !file_.rotation_due(now)) return;
  if (auto done = file_.rotate(); !done) {
    rotate_again_ = place_.scheduler.now() + kRotateAgain;
    return failed(done.error());
  }
  if (auto done = file_.remove_old(); !done) failed(done.error());
  begin_snapshot(recording::kMarkSnapshot);
}

void Recorder::failed(const Error& why) {
  ++counters_.failures;
  complain(why.text);
}

void Recorder::failed_to_write(const Error& why) {
  failed_at_ = place_.scheduler.now();
  pause_ = std::clamp<Duration>(2 * pause_, kFlushEvery, kLongestPause);
  try_again_ = failed_at_ + pause_;
  ++counters_.failures;
  if (reason_.empty()) {
    trouble_since_ = failed_at_;
    dropped_before_ = counters_.dropped;
  }
  if (std::exchange(reason_, why.text) == why.text || !complaints_.allow(why.text, failed_at_)) return;
  log_.error(fmt::format("{}; what cannot be written is dropped", why.text));
  next_count_ = failed_at_ + kCountEvery;
}

void Recorder::drop(std::uint64_t records) {
  counters_.dropped += records;
  gap_ = true;
  const auto now = place_.scheduler.now();
  if (now < next_count_) return;
  next_count_ = now + kCountEvery;
  log_.warning(fmt::format("{} records dropped in {} s: {}", counters_.dropped - dropped_before_,
                           std::chrono::duration_cast<std::chrono::seconds>(now - trouble_since_).count(), reason_));
}

void Recorder::written() {
  const auto now = place_.scheduler.now();
  // A disk that is nearly full takes something again and again: only what stays is a success.
  if (now - failed_at_ >= kLongestPause) pause_ = {};
  if (std::exchange(reason_, {}).empty() || !complaints_.allow("resumed", now)) return;
  log_.info(fmt::format("{}: the recording goes on; {} records were dropped in {} s", file_.path(),
                        counters_.dropped - dropped_before_,
                        std::chrono::duration_cast<std::chrono::seconds>(now - trouble_since_).count()));
}

void Recorder::complain(std::string_view text) {
  if (!complaints_.allow("failure", place_.scheduler.now())) return;
  log_.error(fmt::format("{} ({} records dropped so far, next report in a minute)", text, counters_.dropped));
}

void Recorder::begin_snapshot(std::string_view word) {
  snapshot_.clear();
  for (const auto& pattern : setup_.patterns) {
    place_.space.list(pattern,
                      [this](const tuples::TupleView& tuple) { snapshot_.emplace_back(tuple.owner, tuple.key); });
  }
  if (setup_.patterns.size() > 1) {
    std::sort(snapshot_.begin(), snapshot_.end());
    snapshot_.erase(std::unique(snapshot_.begin(), snapshot_.end()), snapshot_.end());
  }
  const bool running = std::exchange(in_snapshot_, true);
  mark(word);
  if (!running) snapshot_slice();
}

void Recorder::snapshot_slice() {
  for (std::size_t i = 0; i < kSlice && !snapshot_.empty(); ++i) {
    const auto [owner, key] = std::move(snapshot_.back());
    snapshot_.pop_back();
    if (const auto tuple = place_.space.get(owner, key)) add(RecordKind::kPresent, *tuple);
  }
  if (snapshot_.empty()) {
    mark(recording::kMarkComplete);
    write_block();
    if (snapshot_.empty()) {  // else the block ended a gap: what is there by now is still owed
      in_snapshot_ = false;
      file_.snapshot_ends();
      return;
    }
  }
  place_.scheduler.post([this, alive = std::weak_ptr<bool>(alive_)] {
    if (alive.lock()) snapshot_slice();
  });
}

}  // namespace rubicon::recorder
