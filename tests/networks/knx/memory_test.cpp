#include <filesystem>

#include "island/island_state.h"
#include "networks/knx/secure_bench.h"
#include "support/folder.h"

namespace rubicon::networks::knx {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// The network with the memory that an island gives it: a state file.
class SecureKnxMemory : public SecureKnx {
 protected:
  ~SecureKnxMemory() override { network.reset(); }

  void open_state(const std::string& name) {
    network.reset();
    host.state = nullptr;
    memory.reset();
    store = state::StateStore::open(folder / name, IslandId{1}).value();
    memory = std::make_unique<island::NetworkMemory>(store.get());
    host.state = memory.get();
  }
  /// What another process would find if this one were killed now.
  void copy_state(const std::string& from, const std::string& to) {
    for (const auto* part : {"", "-wal"}) {
      if (std::filesystem::exists(folder / (from + part)))
        std::filesystem::copy_file(folder / (from + part), folder / (to + part));
    }
  }

  support::Folder folder;
  std::unique_ptr<state::StateStore> store;
  std::unique_ptr<island::NetworkMemory> memory;
};

TEST_F(SecureKnxMemory, NumbersRiseAndReplaysAreDroppedAfterAKill) {
  open_state("state");
  start(kSecureHouse);
  const auto telegram = from_device(0x0a07, {0x0c, 0x33});
  secure_server->inject_cemi(telegram);
  command(21.5);
  host.time.run_for(20s);
  ASSERT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  ASSERT_THAT(heard(), SizeIs(1));
  const auto first = sequence_of(heard()[0]);
  copy_state("state", "after");
  host.time.set_wall(host.time.wall_now() - 24h * 365);

  open_state("after");
  host.delivered.clear();
  start(kSecureHouse);
  secure_server->inject_cemi(telegram);
  command(22.5);
  EXPECT_THAT(values_of("1/2/7"), IsEmpty());
  ASSERT_THAT(heard(), SizeIs(2));
  EXPECT_GT(sequence_of(heard()[1]), first);
  EXPECT_EQ(count("data-secure-old"), 1U);
}

}  // namespace
}  // namespace rubicon::networks::knx
