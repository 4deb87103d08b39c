#include <sys/mman.h>

#include <filesystem>
#include <new>

#include "history/history_support.h"
#include "state/child.h"
#include "state/crashing_disk.h"

// A process that writes known batches dies before each of its writes to the disk. What is left must be a whole number
// of batches, in their order, none of those that were promised missing.

namespace rubicon::history {
namespace {

using state::CrashPlan;

constexpr int kBatches = 12;
constexpr int kPerBatch = 200;  // so that blocks are closed in some

Batch known_batch(int number) {
  Batch batch{wall(kBegin + number * kMinute), {}, {}, {}};
  for (Slot slot = 0; slot < 2; ++slot) {
    batch.declared.emplace_back(slot, number_series("series." + std::to_string(slot)));
    for (std::int64_t i = number * kPerBatch; i < (number + 1) * kPerBatch; ++i)
      batch.points.push_back({slot, {kBegin + i * 100, static_cast<double>(i % 77)}});
  }
  batch.texts.push_back({1, kBegin + number, std::to_string(number)});
  return batch;
}

/// What the process had done before it died, in memory shared with it.
struct Done {
  int written = 0, promised = 0;
  std::int64_t operations = 0;
};

bool write_all(const std::string& path, Done& done) {
  auto store = Store::open(path, sqlite::FileUse::kOwn, true);
  if (!store) return false;
  for (int number = 0; number < kBatches; ++number) {
    if (!(*store)->write(known_batch(number))) return false;
    done.written = number + 1;
    if (number % 5 == 2) {
      if (!(*store)->sync()) return false;
      done.promised = number + 1;
    }
    if (number == 8 && !(*store)->close_all()) return false;
  }
  store->reset();
  done.operations = state::disk_operations();
  return true;
}

class HistoryPowerLoss : public testing::Test {
 protected:
  void TearDown() override { state::remove_crashing_disk(); }

  int run(const CrashPlan& plan) {
    for (const auto* suffix : {"", "-wal", "-shm", "-lock", "-journal"}) std::filesystem::remove(file() + suffix);
    *done_ = {};
    return state::run_child([&] {
      state::install_crashing_disk(plan);
      return write_all(file(), *done_) ? 0 : 1;
    });
  }

  /// The number of batches that are in the file.
  int survived() {
    state::install_crashing_disk({});
    const auto store = opened(file());
    if (!store) return -1;
    const auto first = values_of(*store, "series.0"), second = values_of(*store, "series.1");
    EXPECT_EQ(first, second);
    EXPECT_EQ(first.size() % kPerBatch, 0U);
    for (std::size_t i = 0; i < first.size(); ++i)
      EXPECT_EQ(first[i], (Point{kBegin + static_cast<std::int64_t>(i) * 100, static_cast<double>(i % 77)}));
    const auto batches = static_cast<int>(first.size()) / kPerBatch;
    EXPECT_EQ(*store->database().number("SELECT count(*) FROM text", "test"), batches);
    EXPECT_EQ(store->damaged(), 0U);
    EXPECT_TRUE(store->write(known_batch(batches))) << "the file cannot be written";
    return batches;
  }

  void die_everywhere(CrashPlan plan) {
    ASSERT_EQ(run({}), 0);
    const auto operations = done_->operations;
    ASSERT_GT(operations, 60);
    for (plan.operation = 1; plan.operation <= operations; ++plan.operation) {
      plan.seed = static_cast<std::uint32_t>(plan.operation);
      ASSERT_EQ(run(plan), state::kCrashed) << "operation " << plan.operation;
      const auto whole = survived();
      const bool process_only = plan.loss == CrashPlan::Loss::kProcess;
      ASSERT_GE(whole, process_only ? done_->written : done_->promised) << "operation " << plan.operation;
      ASSERT_LE(whole, done_->written + 1) << "operation " << plan.operation;
    }
  }

  std::string file() const { return folder_ / "h"; }

  Folder folder_;
  Done* done_ = new (::mmap(nullptr, sizeof(Done), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Done;
};

TEST_F(HistoryPowerLoss, AProcessThatDiesAtAnyWriteLosesNoBatch) {
  die_everywhere({0, CrashPlan::Loss::kProcess});
}

TEST_F(HistoryPowerLoss, PowerThatFailsAtAnyWriteLeavesAllThatWasSynced) {
  die_everywhere({0, CrashPlan::Loss::kUnsynced});
}

TEST_F(HistoryPowerLoss, SectorsThatAreWrittenInAnyOrderDamageNothing) {
  die_everywhere({0, CrashPlan::Loss::kSome});
}

}  // namespace
}  // namespace rubicon::history
