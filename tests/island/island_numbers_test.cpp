#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "island/alerts.h"
#include "island/virtual_island.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;

constexpr OwnerId kIsland{6541};

TEST(IslandNumbers, TheClockIsToldWhileSomebodyAsks) {
  VirtualIsland world("{den: {sensors: {temperature-1: {}}}}");
  int sets = 0;
  WallTime written{};
  const auto take = [&](const tuples::Event& event) {
    if (event.kind != tuples::EventKind::kSet || event.tuple.value.empty()) return;
    ++sets;
    written = event.tuple.write_time;
  };
  const Pattern clock{kIsland, "proxy.property.clock.value"};
  auto passive = world.space->subscribe(clock, {.passive = true}, take);
  world.time.run_for(5s);
  EXPECT_EQ(sets, 0) << "no component asks";
  auto asking = world.space->subscribe(clock, {}, [](const tuples::Event&) {});
  world.time.run_for(10ms);
  EXPECT_EQ(sets, 1);
  world.time.run_for(3s);
  EXPECT_EQ(sets, 4) << "each second";
  EXPECT_LE(world.time.wall_now() - written, 1s);
  asking.reset();
  world.time.run_for(5s);
  EXPECT_EQ(sets, 4);
}

class FreeSpaceTest : public testing::Test {
 protected:
  FreeSpaceTest() { std::filesystem::create_directories(folder_); }
  ~FreeSpaceTest() override { std::filesystem::remove_all(folder_); }

  VirtualScheduler time_;
  FreeSpace space_{time_};
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("rubicon_free_space_" + std::to_string(::getpid()));
};

TEST_F(FreeSpaceTest, IsThatOfTheDiskBesideTheFile) {
  const auto told = space_.beside((folder_ / "home.state").string());
  ASSERT_TRUE(told);
  EXPECT_EQ(*told % 1'000'000, 0U);
  EXPECT_LE(*told, std::filesystem::space(folder_).capacity);
  EXPECT_TRUE(space_.beside("home.state")) << "a file of the working directory";
}

TEST_F(FreeSpaceTest, IsNotKnownWhereThereIsNoFolder) {
  EXPECT_FALSE(space_.beside((folder_ / "absent" / "home.state").string()));
}

TEST_F(FreeSpaceTest, IsLookedUpEachTenSeconds) {
  const auto file = (folder_ / "later" / "home.state").string();
  EXPECT_FALSE(space_.beside(file));
  std::filesystem::create_directories(folder_ / "later");
  time_.run_for(9s);
  EXPECT_FALSE(space_.beside(file));
  time_.run_for(1s);
  EXPECT_TRUE(space_.beside(file));
}

}  // namespace
}  // namespace rubicon::island
