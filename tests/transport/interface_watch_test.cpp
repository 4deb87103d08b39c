#include "transport/interfaces.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/private_network.h"
#include "support/process.h"
#include "transport/machine_sockets.h"
#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

/// On loopback in a network of its own.
class AWatch : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  static bool ip(std::vector<std::string> words) {
    words.insert(words.begin(), "ip");
    return support::run_to_end(words).code == 0;
  }
  template <class World>
  void expect_changes(World& world, const WatchInterfaces& watch) {
    auto opened = watch([this] { ++changes_; });
    ASSERT_TRUE(opened) << opened.error().text;
    const auto is_up = [&] {
      const auto all = (*opened)->interfaces();
      return std::any_of(all.begin(), all.end(), [](const auto& one) { return one.name == "lo" && one.is_up; });
    };
    if (!ip({"address", "add", "127.7.7.7/32", "dev", "lo"})) GTEST_SKIP() << "no program `ip`";
    EXPECT_TRUE(world.until([this] { return changes_ > 0; })) << "an address";
    ASSERT_TRUE(is_up());
    changes_ = 0;
    ASSERT_TRUE(ip({"link", "set", "lo", "down"}));
    EXPECT_TRUE(world.until([&] { return changes_ > 0 && !is_up(); })) << "an interface";
    ASSERT_TRUE(ip({"link", "set", "lo", "up"}));
    EXPECT_TRUE(world.until(is_up));
    opened->reset();
    changes_ = 0;
    ASSERT_TRUE(ip({"address", "del", "127.7.7.7/32", "dev", "lo"}));
    int turns = 0;
    EXPECT_TRUE(world.until([&turns] { return ++turns > 20; }));
    EXPECT_EQ(changes_, 0) << "it ended";
  }

  support::PrivateNetwork alone_;
  int changes_ = 0;
};

TEST_F(AWatch, TellsTheLoopOfADaemon) {
  MachineWorld world;
  expect_changes(world, netlink_interfaces(asio_watch(world.loop)));
}

TEST_F(AWatch, TellsTheLoopOfAClient) {
  PollWorld world;
  expect_changes(world, netlink_interfaces(poll_watch(*world.loop)));
}

}  // namespace
}  // namespace rubicon::transport
