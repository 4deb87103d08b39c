#include "history/measurements.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "frame/process_figures.h"
#include "history/keeper.h"
#include "history/past.h"
#include "history/store.h"

namespace rubicon::bench::history {

namespace {

namespace fs = std::filesystem;
using namespace rubicon::history;

constexpr std::int64_t kStart = 1'767'225'600'000;
constexpr int kPeriod = 10;  // seconds between two values of a series of many

/// A folder on the disk that the measurements write to, gone at the end.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / fmt::format("rubicon_bench_history_{}", ::getpid())) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file() const { return path_ / "bench.history"; }

 private:
  fs::path path_;
};

std::unique_ptr<Store> open_store(const std::string& path, sqlite::FileUse use = sqlite::FileUse::kOwn) {
  auto store = Store::open(path, use, true);
  if (store) return std::move(*store);
  fmt::print(stderr, "{}\n", store.error().text);
  std::exit(1);
}

Declaration series_of(int number) {
  return {{OwnerId(6541), fmt::format("proxy.bench.d{}.sensor.temperature-1.value", number)},
          SeriesKind::kNumber,
          "degC",
          {}};
}

/// A sensor with a resolution of 0.1 that drifts; its times have a jitter of some milliseconds.
struct Sensor {
  int tenths = 215;
  double next(std::mt19937& random) {
    tenths += static_cast<int>(random() % 3) - 1;
    return tenths / 10.0;
  }
};

Result<Answer> ask(Store& store, int series, std::int64_t from, std::int64_t to) {
  return answer(store, {{series_of(series).name}, from_milliseconds(from), from_milliseconds(to), 1000});
}

/// Milliseconds of the median and of the slowest of some questions about different series.
void measure_questions(Store& store, int series, std::int64_t from, std::int64_t to, Json& figures) {
  std::vector<double> times;
  for (int i = 0; i < 50; ++i) {
    const auto start = Clock::now();
    if (!ask(store, i * 97 % series, from, to)) std::exit(1);
    times.push_back(milliseconds(Clock::now() - start));
  }
  figures["question_ms"] = rounded(median(times), 2);
  figures["question_worst_ms"] = rounded(*std::max_element(times.begin(), times.end()), 2);
}

/// Many series with a value each kPeriod seconds, a batch for each second.
class ManySensors {
 public:
  explicit ManySensors(int count) : sensors_(static_cast<std::size_t>(count)) {}

  static std::int64_t time(std::int64_t second) { return kStart + second * rubicon::history::kSecond; }

  /// `is_new`: the store does not know the series of this batch yet, or was opened again.
  Batch batch(std::int64_t second, bool is_new) {
    Batch made{from_milliseconds(time(second)), {}, {}, {}};
    for (auto slot = static_cast<Slot>(second % kPeriod); slot < sensors_.size(); slot += kPeriod) {
      if (is_new) made.declared.emplace_back(slot, series_of(static_cast<int>(slot)));
      made.points.push_back(
          {slot, {time(second) + static_cast<std::int64_t>(random_() % 9), sensors_[slot].next(random_)}});
    }
    return made;
  }

 private:
  std::mt19937 random_{1};
  std::vector<Sensor> sensors_;
};

/// What is older than an hour becomes summaries, in a slice a second as in an island, while values still come.
Json retention_of(Store& store, ManySensors& sensors, int series, std::int64_t second) {
  Retention retention(store, {std::chrono::hours(1), std::nullopt});
  const auto count = [&store](const char* what) { return store.database().number(what, "measuring").value_or(0); };
  std::vector<double> slices;
  for (int i = 0; i <= series / 100; ++i, ++second) {
    if (!store.write(sensors.batch(second, i < kPeriod))) std::exit(1);
    const auto start = Clock::now();
    if (!retention.step(SteadyTime(std::chrono::seconds(second)), from_milliseconds(ManySensors::time(second))))
      std::exit(1);
    slices.push_back(milliseconds(Clock::now() - start));
  }
  return {{"slices", slices.size()},
          {"slice_ms", rounded(median(slices), 1)},
          {"slice_worst_ms", rounded(*std::max_element(slices.begin(), slices.end()), 1)},
          {"points_summed", count("SELECT sum(count) FROM hour")},
          {"summaries", count("SELECT count(*) FROM hour")}};
}

}  // namespace

void measure_day(const Plan& plan, Json& out) {
  const Folder folder;
  auto store = open_store(folder.file());
  ManySensors sensors(plan.series);
  const auto seconds = static_cast<std::int64_t>(plan.hours) * 3600;
  double worst = 0;
  std::uint64_t points = 0;
  const auto processor = thread_seconds();
  for (std::int64_t second = 0; second < seconds; ++second) {
    const auto batch = sensors.batch(second, second < kPeriod);
    const auto start = Clock::now();
    if (!store->write(batch)) std::exit(1);
    worst = std::max(worst, milliseconds(Clock::now() - start));
    points += batch.size();
  }
  const auto used = thread_seconds() - processor;
  Json figures;
  figures["series"] = plan.series;
  figures["points"] = points;
  figures["points_per_s_of_processor"] = rounded(static_cast<double>(points) / used, 0);
  figures["worst_batch_ms"] = rounded(worst, 1);
  figures["resident_mb"] = resident_mb();
  measure_questions(*store, plan.series, kStart, ManySensors::time(seconds), figures);
  store.reset();
  const auto start = Clock::now();
  store = open_store(folder.file());
  figures["open_s"] = rounded(seconds_since(start), 2);
  if (!store->close_all() || !store->database().run("PRAGMA wal_checkpoint(TRUNCATE)", "measuring")) std::exit(1);
  figures["file_mb"] = rounded(static_cast<double>(fs::file_size(folder.file())) / 1e6, 1);
  const auto packed = store->database().number("SELECT sum(length(data)) FROM block", "measuring");
  figures["bytes_per_point"] = rounded(static_cast<double>(*packed) / static_cast<double>(points), 2);
  if (!store->database().run("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)", "measuring")) std::exit(1);
  const auto size = static_cast<double>(fs::file_size(folder.file()));
  figures["file_bytes_per_point"] = rounded(size / static_cast<double>(points), 2);
  figures["retention"] = retention_of(*store, sensors, plan.series, seconds);
  out["day"] = std::move(figures);
}

void measure_month(const Plan& plan, Json& out) {
  const Folder folder;
  auto store = open_store(folder.file());
  std::mt19937 random(2);
  Sensor sensor;
  const auto seconds = static_cast<std::int64_t>(plan.days) * 24 * 3600;
  constexpr std::int64_t kAtOnce = 600;
  for (std::int64_t second = 0; second < seconds; second += kAtOnce) {
    Batch batch{
        from_milliseconds(kStart + (second + kAtOnce) * rubicon::history::kSecond), {{0, series_of(0)}}, {}, {}};
    for (std::int64_t i = 0; i < kAtOnce; ++i)
      batch.points.push_back(
          {0,
           {kStart + (second + i) * rubicon::history::kSecond + static_cast<std::int64_t>(random() % 9),
            sensor.next(random)}});
    if (!store->write(batch)) std::exit(1);
  }
  Json figures;
  figures["points"] = seconds;
  figures["file_mb"] = rounded(static_cast<double>(fs::file_size(folder.file())) / 1e6, 1);
  measure_questions(*store, 1, kStart, kStart + seconds * rubicon::history::kSecond, figures);
  Json day;
  measure_questions(*store, 1, kStart + kDay, kStart + 2 * kDay, day);
  figures["one_day"] = std::move(day);
  out["month"] = std::move(figures);
}

}  // namespace rubicon::bench::history
