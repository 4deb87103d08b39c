#include "history/import.h"

#include <fmt/format.h>

#include <algorithm>

#include "history/intake.h"
#include "model/point_keys.h"
#include "recording/recording_reader.h"

namespace rubicon::history {

namespace {

using recording::Record;
using recording::RecordKind;

constexpr std::size_t kBatch = 1'000'000;  // bytes
constexpr auto kTickEvery = std::chrono::seconds(10);

Result<void> walk(transport::Transports& transports, const std::string& path, const recording::VisitItem& visit) {
  const auto file = transports.open_file(path);
  if (!file) return fail(file.error());
  return recording::each_item([&](std::span<std::uint8_t> into) { return (*file)->read(into); }, visit);
}

/// Whether the tuple is a value that was asked for, or says what such a value is.
bool wanted(const std::vector<Pattern>& patterns, const Record& record) {
  const auto matches = [&](std::string_view key) {
    return std::any_of(patterns.begin(), patterns.end(),
                       [&](const Pattern& one) { return one.matches(record.owner, key); });
  };
  if (matches(record.key)) return true;
  const auto point = model::point_of(record.key);
  return point && matches(point->value());
}

class Import {
 public:
  Import(Store& store, const ImportRules& rules) : store_(store), rules_(rules), intake_(rules.exclude) {
    std::vector<Declaration> known;
    for (const auto& [row, one] : store.series()) known.push_back(one.declaration);
    intake_.seed(known);
    intake_.limit(std::numeric_limits<std::size_t>::max());
    store.forget_slots();
  }

  Result<void> take(const Record& record, Duration shift, Imported& done) {
    ++done.records;
    const auto moved = std::chrono::duration_cast<std::chrono::microseconds>(shift);
    now_ = record.seen + moved;
    // The island started again: an earlier value may not have lasted until now.
    if (record.kind == RecordKind::kMark || !wanted(rules_.patterns, record)) return {};
    if (record.kind == RecordKind::kDeleted || record.kind == RecordKind::kExpired) {
      intake_.gone(record.owner, record.key, Instant::recorded(now_));
    } else {
      intake_.changed(tuple_of(record, moved), Instant::recorded(now_));
    }
    if (now_ >= next_tick_) {
      next_tick_ = now_ + kTickEvery;
      intake_.tick(Instant::recorded(now_));
    }
    return intake_.bytes() < kBatch ? Result<void>() : write(done);
  }

  Result<void> finish(Imported& done) {
    intake_.tick(Instant::recorded(now_ + std::chrono::seconds(5)));  // what waits for its status waits no longer
    done.unfit = intake_.unfit();
    if (auto written = write(done); !written) return written;
    store_.forget_slots();
    return store_.close_all();
  }

 private:
  static TupleView tuple_of(const Record& record, std::chrono::microseconds moved) {
    TupleView tuple;
    tuple.owner = record.owner;
    tuple.key = record.key;
    tuple.value = record.value;
    tuple.write_time = record.write_time + moved;
    if (record.user_time != WallTime()) tuple.user_time = record.user_time + moved;
    return tuple;
  }

  Result<void> write(Imported& done) {
    const auto batch = intake_.take(now_);
    done.points += batch.size();
    return batch.empty() ? Result<void>() : store_.write(batch);
  }

  Store& store_;
  const ImportRules& rules_;
  Intake intake_;
  WallTime now_{}, next_tick_{};
};

}  // namespace

Result<Imported> import_recording(Store& store, transport::Transports& transports, const std::string& path,
                                  const ImportRules& rules) {
  Imported done;
  bool sound = false;
  auto looked = walk(transports, path, [&](const auto& item) -> Result<void> {
    if (const auto* block = std::get_if<recording::BlockFound>(&item)) {
      if (!std::exchange(sound, true)) done.first = block->head.first;
      done.last = block->head.last;
    }
    if (std::holds_alternative<recording::Damage>(item)) ++done.damage;
    return {};
  });
  if (!looked) return fail(looked.error());
  if (!sound) return fail(ErrorCode::kInvalid, path + ": is not a recording");
  const Duration shift = rules.end ? *rules.end - done.last : Duration(0);
  Import import(store, rules);
  looked = walk(transports, path, [&](const auto& item) -> Result<void> {
    const auto* record = std::get_if<Record>(&item);
    return record ? import.take(*record, shift, done) : Result<void>();
  });
  if (looked) looked = import.finish(done);
  if (!looked) return fail(looked.error());
  return done;
}

}  // namespace rubicon::history
