#include "history/keeper.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <tuple>

#include "history/history_file.h"

namespace rubicon::history {

namespace {

constexpr Duration kFirstPause = std::chrono::seconds(1), kLongestPause = std::chrono::minutes(1);
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
  pause_ = std::clamp<Duration>(2 * pause_, kFirstPause, kLongestPause);
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
