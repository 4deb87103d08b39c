#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

// The program on a real mosquitto, in a network of its own.
namespace rubicon::zigbee_simulator {
namespace {

using support::Mosquitto;
using support::MosquittoListener;
using support::Process;
using ::testing::HasSubstr;

const std::string kRecordedTrace = RUBICON_SOURCE_DIR "/../shared/data/zigbee/trace16-small.jsonl";

class ZigbeeProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!network_.entered()) GTEST_SKIP() << network_.reason();
    if (const auto missing = Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
  }
  void start_broker() {
    broker = std::make_unique<Mosquitto>();
    listen();
  }
  void listen() {
    while (!broker->ready()) std::this_thread::yield();
    listener = std::make_unique<MosquittoListener>(*broker, "zigbee2mqtt/#");
  }
  void start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), support::kZigbeeSimulator);
    program = std::make_unique<Process>(std::move(arguments));
  }
  /// The next message that begins so; empty if there is none.
  std::string message(const std::string& beginning) {
    while (const auto next = listener->next()) {
      if (next->starts_with(beginning)) return *next;
    }
    return {};
  }

  support::PrivateNetwork network_;
  std::unique_ptr<Mosquitto> broker;
  std::unique_ptr<MosquittoListener> listener;
  std::unique_ptr<Process> program;
};

TEST_F(ZigbeeProgram, HasOneDeviceOfEachModelAndDoesWhatClientsAsk) {
  start_broker();
  start({});
  EXPECT_EQ(program->line(), "12 devices, zigbee2mqtt at 127.0.0.1:1883");
  EXPECT_EQ(broker->publish("zigbee2mqtt/plug 2/set", R"({"state":"OFF"})").code, 0);
  EXPECT_THAT(message("zigbee2mqtt/plug 2 "), HasSubstr(R"("state":"ON")")) << "the start-up copy";
  EXPECT_THAT(message("zigbee2mqtt/plug 2 "), HasSubstr(R"("state":"ON")")) << "heard";
  EXPECT_THAT(message("zigbee2mqtt/plug 2 "), HasSubstr(R"("state":"OFF")")) << "the echo";
  program->signal(SIGTERM);
  EXPECT_EQ(program->exit_code(), 0) << program->errors();
  EXPECT_EQ(message("zigbee2mqtt/bridge/state"), R"(zigbee2mqtt/bridge/state {"state":"offline"})");
}

TEST_F(ZigbeeProgram, LeavesItsWillWhenItIsKilled) {
  start_broker();
  start({"--devices", "1"});
  ASSERT_TRUE(program->line());
  EXPECT_EQ(message("zigbee2mqtt/bridge/state"), R"(zigbee2mqtt/bridge/state {"state":"online"})");
  program->signal(SIGKILL);
  EXPECT_EQ(message("zigbee2mqtt/bridge/state"), R"(zigbee2mqtt/bridge/state {"state":"offline"})");
}

TEST_F(ZigbeeProgram, ComesBackAfterTheBrokerWasAway) {
  start_broker();
  start({"--devices", "1"});
  ASSERT_TRUE(program->line());
  listener.reset();
  broker->kill();
  broker->start();
  listen();
  EXPECT_EQ(message("zigbee2mqtt/"), R"(zigbee2mqtt/bridge/state {"state":"online"})");
  program->signal(SIGTERM);
  EXPECT_EQ(program->exit_code(), 0);
}

TEST_F(ZigbeeProgram, WaitsForABrokerAndReportsItOnce) {
  start({"--generated", "20", "--seed", "4"});
  while (program->errors().empty()) std::this_thread::yield();
  start_broker();
  EXPECT_EQ(program->line(), "20 devices, zigbee2mqtt at 127.0.0.1:1883");
  program->signal(SIGINT);
  EXPECT_EQ(program->exit_code(), 0);
  const auto errors = program->errors();
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
}

TEST_F(ZigbeeProgram, ReplaysATraceAndEnds) {
  if (!std::filesystem::exists(kRecordedTrace)) GTEST_SKIP() << "no ../shared/data/zigbee/trace16-small.jsonl";
  start_broker();
  start({"--replay", kRecordedTrace, "--speed", "0"});
  EXPECT_EQ(program->line(), "449 messages, zigbee2mqtt at 127.0.0.1:1883");
  EXPECT_EQ(program->exit_code(), 0) << program->errors();
  int messages = 0, lists = 0;
  std::string last;
  while (last != R"(zigbee2mqtt/bridge/state {"state":"offline"})") {
    const auto next = listener->next();
    ASSERT_TRUE(next) << messages;
    last = *next;
    ++messages;
    lists += last.starts_with("zigbee2mqtt/bridge/devices ") ? 1 : 0;
  }
  EXPECT_EQ(messages, 449);
  EXPECT_EQ(lists, 64);
}

TEST(ZigbeeProgramArguments, AreNamedIfTheyAreWrong) {
  const auto outcome = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), support::kZigbeeSimulator);
    return support::run_to_end(std::move(arguments));
  };
  const auto file = (std::filesystem::temp_directory_path() / "rubicon-zigbee-wrong.script").string();
  std::ofstream(file) << "device toaster x\n";
  for (const auto& [arguments, why] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--broker", "host:port"}, "--broker: expected HOST[:PORT]"},
           {{"--every", "often"}, "--every: expected at least 1ms"},
           {{"--base", "a/#"}, "--base: expected a topic without + and #"},
           {{"--devices", "many"}, "--devices"},
           {{"--speed", "2"}, "--replay"},
           {{"nothing.script"}, "nothing.script"},
           {{"--replay", file}, file + ": line 1: expected a JSON object"},
           {{file}, file + ": line 1: 'toaster': expected random or one of lamp"}}) {
    const auto end = outcome(arguments);
    EXPECT_EQ(end.code, 2) << why;
    EXPECT_THAT(end.errors, HasSubstr(why));
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
