#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "fuzz_target.h"
#include "history/history_source.h"
#include "history/past.h"

namespace rubicon::fuzz::history_question_fuzz {

namespace {

using namespace rubicon::history;

constexpr std::int64_t kSomeDay = 1'767'225'600'000;

void holds(bool condition) {
  if (!condition) std::abort();
}

/// In memory where there is a place for that.
struct PlaceOfHistory {
  std::filesystem::path path =
      std::filesystem::path(::access("/dev/shm", W_OK) == 0 ? "/dev/shm"
                                                            : std::filesystem::temp_directory_path().string()) /
      ("rubicon-fuzz-history-" + std::to_string(::getpid()));
  PlaceOfHistory() { std::filesystem::create_directories(path); }
  ~PlaceOfHistory() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

/// Numbers of the input; zeros behind its end.
struct Numbers {
  template <class Number>
  Number next() {
    Number number{};
    const auto size = std::min(sizeof number, rest.size());
    if (size > 0) std::memcpy(&number, rest.data(), size);
    rest = rest.subspan(size);
    return number;
  }
  ByteView bytes(std::size_t most) {
    const auto some = rest.first(std::min(most, rest.size()));
    rest = rest.subspan(some.size());
    return some;
  }
  /// Near a day, or anywhere.
  std::int64_t time() {
    const auto offset = next<std::int32_t>();
    return offset == INT32_MIN ? next<std::int64_t>() : kSomeDay + offset;
  }

  ByteView rest;
};

/// A file with a series of each kind. Each input adds to it, and what it added is taken back afterwards.
class World {
 public:
  World() {
    Batch batch{from_milliseconds(kSomeDay), {}, {}, {}};
    for (Slot slot = 0; slot < 3; ++slot) {
      batch.declared.push_back({slot, {name(slot), static_cast<SeriesKind>(slot), "lx", {}}});
      if (slot == 1) batch.declared.back().second.words = {"off", "on"};
    }
    for (int i = 0; i < 100; ++i) batch.points.push_back({0, {kSomeDay + i * 700, i % 30 == 29 ? kGap : i / 10.0}});
    batch.points.push_back({1, {kSomeDay, 1}});
    batch.texts.push_back({2, kSomeDay, "text"});
    holds(store_->write(batch).has_value());
  }

  static SeriesName name(std::uint32_t slot) { return {OwnerId(1), "robot.s" + std::to_string(slot)}; }

  void put(Numbers& numbers) {
    const auto kind = numbers.next<std::uint8_t>();
    const auto series = 1 + kind / 4 % 3;
    switch (kind % 4) {
      case 0: return put_points(series, numbers);
      case 1: return put_any_block(series, numbers);
      case 2: return put_hour(series, numbers);
      default: return put_text(series, numbers);
    }
  }

  Store& store() { return *store_; }

 private:
  /// A block as the store writes it.
  void put_points(int series, Numbers& numbers) {
    Points points;
    auto time = kSomeDay + numbers.next<std::int32_t>();
    Summed sum;
    std::int64_t gaps = 0;
    for (auto count = 1 + numbers.next<std::uint8_t>() % 64; count > 0; --count) {
      time += numbers.next<std::uint16_t>();
      const auto value = numbers.next<std::int8_t>();
      points.push_back({time, value == INT8_MIN ? kGap : value / 10.0});
      if (points.back().gap()) ++gaps;
      if (!points.back().gap()) sum.add(time, points.back().value);
    }
    each_hold(points, [&](double value, std::int64_t from, std::int64_t until) { sum.hold(value, until - from); });
    put_block(series, points.front().time, time, sum, gaps, store_->codec().encode(points));
  }
  /// One that a damaged file may have.
  void put_any_block(int series, Numbers& numbers) {
    const auto start = numbers.time(), end = numbers.time();
    Summed sum;
    sum.count = numbers.next<std::uint32_t>();
    sum.minimum = numbers.next<float>();
    sum.sum = numbers.next<float>();
    sum.area = numbers.next<float>();
    sum.held = numbers.time();
    const auto gaps = numbers.next<std::int8_t>();
    put_block(series, start, end, sum, gaps, numbers.bytes(100));
  }
  void put_block(int series, std::int64_t start, std::int64_t end, const Summed& sum, std::int64_t gaps,
                 ByteView data) {
    sqlite::Query query(block_);
    query.integer(series).integer(start).integer(++part_).integer(end).integer(sum.count).integer(gaps);
    query.real(sum.minimum).real(sum.maximum).real(sum.sum).real(sum.last).blob(data);
    query.real(sum.first).real(sum.area).integer(sum.held);
    holds(query.run().has_value());
  }
  void put_hour(int series, Numbers& numbers) {
    const auto start = numbers.time(), end = numbers.time();
    sqlite::Query query(hour_);
    query.integer(series).integer(start).integer(end).integer(numbers.next<std::int32_t>());
    for (int i = 0; i < 6; ++i) query.real(numbers.next<float>());
    query.integer(numbers.time());
    holds(query.run().has_value());
  }
  void put_text(int series, Numbers& numbers) {
    const auto time = numbers.time();
    const auto text = numbers.bytes(20);
    sqlite::Query query(text_);
    query.integer(series).integer(time).text({reinterpret_cast<const char*>(text.data()), text.size()});
    holds(query.run().has_value());
  }

  sqlite::Statement prepared(const char* sql) { return std::move(*store_->database().prepare(sql, "fuzzing")); }

  PlaceOfHistory place_;
  std::unique_ptr<Store> store_ = std::move(*Store::open(place_.path / "h", sqlite::FileUse::kOwn, false));
  sqlite::Statement block_ = prepared("INSERT INTO block VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
  sqlite::Statement hour_ = prepared("INSERT OR REPLACE INTO hour VALUES(?,?,?,?,?,?,?,?,?,?,?)");
  sqlite::Statement text_ = prepared("INSERT OR REPLACE INTO text VALUES(?,?,?)");
  std::int64_t part_ = 0;
};

Question question_of(Numbers& numbers) {
  Question question;
  for (auto count = numbers.next<std::uint8_t>() % 5; count > 0; --count)
    question.series.push_back(World::name(numbers.next<std::uint8_t>() % 4));  // one of them is not there
  // A WallTime has microseconds: of further times there is none.
  const auto time = [&] { return from_milliseconds(std::clamp(numbers.time(), -kFurthest - 1, kFurthest + 1)); };
  question.from = time();
  question.to = time();
  question.buckets = numbers.next<std::uint16_t>();
  return question;
}

void check(const Question& question, const Answer& answer) {
  holds(answer.series.size() == question.series.size());
  holds(answer.from <= question.from && answer.to >= question.to);
  for (std::size_t i = 0; i < answer.series.size(); ++i) {
    const auto& series = answer.series[i];
    holds(series.name == question.series[i]);
    holds(series.buckets.size() <= std::max<std::size_t>(question.buckets, 2));  // 2: across 1970
    holds(series.texts.size() <= question.buckets);
    for (std::size_t k = 0; k < series.buckets.size(); ++k) {
      const auto& bucket = series.buckets[k];
      holds(bucket.time >= answer.from && bucket.time < answer.to);
      holds(k == 0 || series.buckets[k - 1].time < bucket.time);
    }
    for (std::size_t k = 0; k < series.gaps.size(); ++k) {
      const auto& gap = series.gaps[k];
      holds(gap.from >= answer.from && gap.to <= answer.to && gap.from < gap.to);
      holds(k == 0 || series.gaps[k - 1].to <= gap.from);
    }
  }
  holds(nlohmann::json::parse(to_json(answer), nullptr, false).is_object());
  holds(to_csv(answer).starts_with("time,key,"));
}

}  // namespace

/// A question, then what the file has: blocks, summaries and texts, sound ones and others.
FUZZ_TARGET(history_question) {
  static World world;
  auto& store = world.store();
  Numbers numbers{ByteView(data, size)};
  const auto question = question_of(numbers);
  holds(store.database().run("BEGIN", "fuzzing").has_value());
  for (int i = 0; i < 50 && !numbers.rest.empty(); ++i) world.put(numbers);
  const auto found = answer(store, question);
  if (found) check(question, *found);
  if (!found) holds(found.error().code == ErrorCode::kInvalid);
  const auto listed = list_series(store, {std::nullopt, "robot.*"}, {"1:robot.s0", 2});
  holds(listed && listed->size() == 2);
  holds(nlohmann::json::parse(to_json(*listed), nullptr, false).is_object());
  holds(store.database().run("ROLLBACK", "fuzzing").has_value());
  return 0;
}

}  // namespace rubicon::fuzz::history_question_fuzz
