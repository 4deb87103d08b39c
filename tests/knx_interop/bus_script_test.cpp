#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/private_network.h"
#include "support/knxd.h"

namespace rubicon::networks::knx {
namespace {

using ::testing::HasSubstr;

const std::string kScript = RUBICON_SOURCE_DIR "/examples/knx-bus.sh";

/// knxd joins the group of KNX even for a tunnel on loopback, and ends where nothing leads there.
TEST(BusOfTheDemo, SaysWhyItCannotBeThereWithoutARouteToTheGroup) {
  {
    const support::KnxNetwork tools;
    if (!tools.entered()) GTEST_SKIP() << tools.reason();
  }
  const daemon::PrivateNetwork without_routes;
  ASSERT_TRUE(without_routes.entered()) << without_routes.reason();
  const auto ended = daemon::run_to_end({"bash", kScript});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.errors, HasSubstr("no route to the multicast group 224.0.23.12"));
}

TEST(BusOfTheDemo, RunsUntilItIsEndedWhereThereIsARoute) {
  const support::KnxNetwork network;
  if (!network.entered()) GTEST_SKIP() << network.reason();
  daemon::Process bus({"bash", kScript});
  const auto listener = daemon::run_to_end({"bash", "-c", "until grep -q ':3567 ' /proc/net/udp; do sleep 0.1; done"});
  EXPECT_EQ(listener.code, 0) << "port 13671 is 3567 in hex";
  bus.signal(SIGTERM);
  EXPECT_EQ(bus.exit_code(), 0);
}

}  // namespace
}  // namespace rubicon::networks::knx
