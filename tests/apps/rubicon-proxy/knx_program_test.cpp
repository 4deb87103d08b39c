#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using testing::HasSubstr;

const std::string kScript = RUBICON_SOURCE_DIR "/examples/knx.script";

TEST(KnxProgram, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(run_to_end({kKnxSimulator, "--help"}).code, 0);
  EXPECT_EQ(run_to_end({kKnxSimulator, "--version"}).code, 0);
  for (const auto& bad : std::vector<std::vector<std::string>>{
           {"--nonsense", kScript}, {}, {kScript, "--listen", "70000"}, {kScript, "--loss", "2"}, {"/nowhere"}}) {
    auto words = bad;
    words.insert(words.begin(), kKnxSimulator);
    const auto run = run_to_end(words);
    EXPECT_EQ(run.code, 2) << run.errors;
    EXPECT_NE(run.errors, "");
  }
}

TEST(KnxProgram, AnIslandReadsItsSensorsAndWritesToItsLine) {
  const PrivateNetwork network;
  if (!network.entered()) GTEST_SKIP() << network.reason();
  Process simulator({kKnxSimulator, kScript, "--listen", "13671", "--log-level", "info"});
  ASSERT_THAT(simulator.line().value_or(""), HasSubstr("8 group addresses, tunnels at 127.0.0.1 port 13671"));
  EXPECT_EQ(run_to_end({kKnxSimulator, kScript, "--listen", "13671"}).code, 1) << "its port is in use";
  Process shell({kDaemon, "run", RUBICON_SOURCE_DIR "/examples/knx.yaml", "--set", "tuples.engine=memory", "--shell"});
  shell.write("subscribe proxy.knx-demo.*.sensor.*.value\n");
  EXPECT_TRUE(shell.line_with(R"(1_2_7.sensor.temperature-1.value","value":"2)")) << "its value was not read";
  shell.close_input();
  EXPECT_EQ(shell.exit_code(), 0);
  simulator.signal(SIGTERM);
  EXPECT_EQ(simulator.exit_code(), 0);
  EXPECT_THAT(simulator.errors(), HasSubstr("1.1.200 read 1/2/7"));
  EXPECT_THAT(simulator.errors(), HasSubstr("1.1.200 write 6/0/1"));
}

}  // namespace
}  // namespace rubicon::daemon
