#include <sys/mman.h>

#include <algorithm>

#include "state/child.h"
#include "state/crashing_disk.h"
#include "state/state_support.h"

// A process that does known transactions dies before each of its writes. What is left must be the work of a whole
// number of transactions: none half, none out of turn, none that was promised missing.

namespace rubicon::state {
namespace {

constexpr int kTransactions = 12;

bool durable(int number) {
  return (number % 4 == 2 && number % 5 != 4) || number % 5 == 1;
}

std::vector<StoredValue> values_of(int number) {
  return {value_at(sensor(1), double(number), number),
          value_at(sensor(2), std::string(static_cast<std::size_t>(number) * 40, 'v'), number)};
}

/// New devices, renewed and forgotten ones, values that grow: over several pages, some reused.
bool transaction(StateStore& store, int number) {
  if (number % 5 == 4) {  // one without begin
    auto device = device_of("solo", std::to_string(number));
    device.values = values_of(number);
    return store.save(device).has_value();
  }
  if (number % 5 == 1)
    return store.remember("wsn-1", "sequence", Bytes(3, static_cast<std::uint8_t>(number)), 1).has_value();
  if (!store.begin()) return false;
  for (int i = 0; i < 2; ++i) {
    auto device = device_of("wsn-1", std::to_string((number * 2 + i) % 14));
    device.last_heard = at(number);
    device.decision = number % 3 == 0 ? Decision::kIgnored : Decision::kApproved;
    const auto row = store.save(device);
    if (!row || !store.save_values(*row, values_of(number))) return false;
  }
  if (number % 3 == 2) std::ignore = store.forget("wsn-1", std::to_string(number));
  return store.commit(durable(number)).has_value();
}

/// The commits that the process had finished before it died, in memory shared with it.
struct Progress {
  int committed = 0;
  int promised = 0;
  std::int64_t operations = 0;
};

Progress* shared_progress() {
  void* memory = ::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return new (memory) Progress;
}

/// True: everything went as written.
bool work(const std::string& path, Progress& progress) {
  auto store = StateStore::open(path, kIsland);
  if (!store) return false;
  for (int number = 0; number < kTransactions; ++number) {
    if (!transaction(**store, number)) return false;
    progress.committed = number + 1;
    if (durable(number)) progress.promised = number + 1;
    if (number % 5 == 3 && !(*store)->tidy()) return false;
  }
  store->reset();
  progress.operations = disk_operations();
  return true;
}

class PowerLoss : public testing::Test {
 protected:
  void SetUp() override {
    install_crashing_disk({});
    snapshots_.push_back("");
    const auto store = opened(folder_ / "model");
    for (int number = 0; number < kTransactions; ++number) {
      ASSERT_TRUE(transaction(*store, number));
      snapshots_.push_back(snapshot(*store));
    }
  }

  void TearDown() override { remove_crashing_disk(); }

  int run(const CrashPlan& plan) {
    for (const auto* suffix : {"", "-wal", "-shm", "-lock", "-journal"}) std::filesystem::remove(file() + suffix);
    *progress_ = {};
    return run_child([&] {
      install_crashing_disk(plan);
      return work(file(), *progress_) ? 0 : 1;
    });
  }

  /// The number of transactions whose work is in the file; -1: it is no such number.
  int survived() {
    install_crashing_disk({});
    const auto store = StateStore::open(file(), kIsland);
    if (!store) {
      ADD_FAILURE() << store.error().text;
      return -1;
    }
    const auto found = std::find(snapshots_.begin(), snapshots_.end(), snapshot(**store));
    if (found == snapshots_.end()) return -1;
    EXPECT_TRUE((*store)->save(device_of("after", "1"))) << "the file cannot be written";
    return static_cast<int>(found - snapshots_.begin());
  }

  void die_everywhere(CrashPlan plan) {
    ASSERT_EQ(run({}), 0);
    const auto operations = progress_->operations;
    ASSERT_GT(operations, 100);
    for (plan.operation = 1; plan.operation <= operations; ++plan.operation) {
      plan.seed = static_cast<std::uint32_t>(plan.operation);
      ASSERT_EQ(run(plan), kCrashed) << "operation " << plan.operation;
      const auto whole = survived();
      const bool process_only = plan.loss == CrashPlan::Loss::kProcess;
      ASSERT_GE(whole, process_only ? progress_->committed : progress_->promised) << "operation " << plan.operation;
      ASSERT_LE(whole, progress_->committed + 1) << "operation " << plan.operation;
      lost_ += progress_->committed > whole ? 1 : 0;
    }
  }

  std::string file() const { return folder_ / "state"; }

  Folder folder_;
  Progress* progress_ = shared_progress();
  std::vector<std::string> snapshots_;
  int lost_ = 0;  ///< deaths that took back what was committed
};

TEST_F(PowerLoss, AProcessThatDiesAtAnyWriteLosesNothingItCommitted) {
  die_everywhere({0, CrashPlan::Loss::kProcess});
}

TEST_F(PowerLoss, PowerThatFailsAtAnyWriteLeavesAPrefixWithAllThatWasDurable) {
  die_everywhere({0, CrashPlan::Loss::kUnsynced});
  EXPECT_GT(lost_, 0) << "the disk of this test forgets nothing";
}

TEST_F(PowerLoss, PowerThatFailsWithHalfTheSectorsWrittenDoesSoToo) {
  die_everywhere({0, CrashPlan::Loss::kSome});
  EXPECT_GT(lost_, 0);
}

}  // namespace
}  // namespace rubicon::state
