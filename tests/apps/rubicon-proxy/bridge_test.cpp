#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using testing::HasSubstr;

/// The real program with a bridge, and a real broker.
class DaemonWithBridge : public testing::Test {
 protected:
  void SetUp() override {
    if (!own_network_.entered()) GTEST_SKIP() << own_network_.reason();
    if (const auto missing = Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
    folder_ = testing::TempDir() + "bridge-XXXXXX";
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    broker_ = std::make_unique<Mosquitto>();
    for (int i = 0; i < 2000 && !broker_->ready(); ++i) ::usleep(5'000);
    ASSERT_TRUE(broker_->ready()) << broker_->errors();
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::string write(const std::string& more) {
    std::ofstream(folder_ + "/home.yaml")
        << "island: {id: 6541, name: test}\ntuples: {engine: memory}\naudit: {file: home.audit}\n"
           "networks: {dummy-1: {type: dummy, simulate: {room: {name: Room, actuators: {lamp-1: {value: off}}}}}}\n"
        << more;
    return folder_ + "/home.yaml";
  }
  /// The payloads of the topic until this one; false: it does not come within a minute.
  static bool comes(MosquittoListener& listener, const std::string& text) {
    for (auto next = listener.next(); next; next = listener.next()) {
      if (*next == text) return true;
    }
    return false;
  }

  PrivateNetwork own_network_;
  std::unique_ptr<Mosquitto> broker_;
  std::string folder_;
};

constexpr const char* kBridge = "bridges: {ha: {type: mqtt, broker: localhost, commands: yes}}\n";

TEST_F(DaemonWithBridge, ShowsCommandsAndAuditsAndEndsOneByAReload) {
  MosquittoListener listener(*broker_, "rubicon/#");
  Process daemon({kDaemon, "run", write(kBridge)});
  ASSERT_TRUE(comes(listener, "rubicon/6541/dummy-1/room/actuator/lamp-1 off"));
  std::ignore = broker_->publish("rubicon/6541/dummy-1/room/actuator/lamp-1/set", "on");
  ASSERT_TRUE(comes(listener, "rubicon/6541/dummy-1/room/actuator/lamp-1 on"));
  std::ifstream file(folder_ + "/home.audit");
  std::stringstream audit;
  audit << file.rdbuf();
  EXPECT_THAT(audit.str(), HasSubstr(R"("bridge:ha")")) << "also without rights";
  write("");
  daemon.signal(SIGHUP);
  ASSERT_TRUE(comes(listener, "rubicon/6541/online offline"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.exit_code(), 0) << daemon.errors();
}

TEST_F(DaemonWithBridge, GoesOnWithoutItsBroker) {
  broker_->kill();
  Process daemon({kDaemon, "run", "--shell", write(kBridge)});
  daemon.write("devices\n");
  EXPECT_TRUE(daemon.line());
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.exit_code(), 0) << daemon.errors();
  EXPECT_THAT(daemon.errors(), HasSubstr("island 6541 is up"));
}

TEST_F(DaemonWithBridge, NamesWhatIsWrongWithItsOptions) {
  const auto wrong = [&](const std::string& options) {
    return run_to_end({kDaemon, "check", write("bridges: {ha: " + options + "}\n")}).errors;
  };
  EXPECT_THAT(wrong("{type: mqtt}"), HasSubstr("home.yaml:5:"));
  EXPECT_THAT(wrong("{type: mqtt}"), HasSubstr("'broker' is missing"));
  EXPECT_THAT(wrong("{type: mqqt, broker: b}"), HasSubstr("expected one of: mqtt"));
  EXPECT_THAT(wrong("{type: mqtt, broker: b, base: rubicon-space}"), HasSubstr("bridges.ha.base"));
  EXPECT_THAT(wrong("{type: mqtt, broker: b, comands: yes}"), HasSubstr("commands"));
}

}  // namespace
}  // namespace rubicon::daemon
