#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "apps/simulators/zigbee/simulator.h"
#include "network/supervisor.h"
#include "networks/zigbee/zigbee_network.h"
#include "support/collecting_log.h"
#include "support/config_text.h"
#include "support/mosquitto.h"
#include "support/private_network.h"
#include "transport/worlds.h"

namespace rubicon::networks::zigbee {
namespace {

using namespace std::chrono_literals;
using support::Certificates;
using support::Mosquitto;
using support::MosquittoOptions;
using ::testing::HasSubstr;
using ::testing::Not;

/// The network, its supervisor and a simulated bridge on a real mosquitto, in real time.
class OnMosquitto : public ::testing::Test, public network::MessageSink {
 protected:
  void SetUp() override {
    if (!own_network_.entered()) GTEST_SKIP() << own_network_.reason();
    if (const auto missing = Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
    folder_ = ::testing::TempDir() + "zigbee-XXXXXX";
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    machine_ = std::make_unique<transport::MachineWorld>();
  }
  void TearDown() override {
    supervisor_.reset();
    bridge_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  void from_network(const std::string&, Message&& message) override { said_.push_back(std::move(message)); }

  Scheduler& scheduler() { return machine_->loop.scheduler(); }
  std::string secret(const std::string& password) {
    std::ofstream(folder_ + "/secret") << password << '\n';
    std::filesystem::permissions(folder_ + "/secret", std::filesystem::perms::owner_read);
    return folder_ + "/secret";
  }
  void begin_broker(MosquittoOptions options) {
    broker_ = std::make_unique<Mosquitto>(std::move(options));
    ASSERT_TRUE(machine_->until([&] { return broker_->ready(); })) << broker_->errors();
  }
  void begin_bridge(transport::MqttOptions at) {
    at.host = "127.0.0.1";
    world_ =
        std::make_unique<zigbee_simulator::World>(zigbee_simulator::WorldOptions{}, scheduler(), Log(words_, "bridge"));
    bridge_ = std::make_unique<zigbee_simulator::BrokerLine>(*world_, at, scheduler(), machine_->local,
                                                             Log(words_, "bridge"));
    for (const auto* model : {"plug", "thermometer"})
      ASSERT_TRUE(world_->add(zigbee_simulator::find_model(model).value(), model));
    ASSERT_TRUE(bridge_->open());
    ASSERT_TRUE(machine_->until([&] { return bridge_->connected(); }));
  }
  void begin_network(const nlohmann::ordered_json& broker) {
    options_ = support::config_of(nlohmann::ordered_json{{"broker", broker}});
    ConfigReader reader(options_, "networks.zigbee", errors_);
    supervisor_ = std::make_unique<network::Supervisor>(IslandId{1}, scheduler(), machine_->local, words_, *this);
    const auto added = supervisor_->add(kType, {"zigbee", IslandId{1}, reader, types_, {}});
    ASSERT_TRUE(added) << errors_.text();
    supervisor_->start();
  }
  bool is(model::LineState line) const {
    const model::State* newest = nullptr;
    for (const auto& message : said_) {
      if (const auto* state = std::get_if<model::State>(&message.body)) newest = state;
    }
    return newest != nullptr && newest->line == line;
  }
  template <class Body>
  std::size_t count() const {
    return static_cast<std::size_t>(std::count_if(
        said_.begin(), said_.end(), [](const auto& one) { return std::holds_alternative<Body>(one.body); }));
  }
  /// Both devices joined, and the plug obeys: its relay goes off, and it says so when it is asked.
  void expect_a_whole_command() {
    ASSERT_TRUE(machine_->until([&] { return is(model::LineState::kUp) && count<model::Join>() == 2; }));
    Message message;
    message.destination = {IslandId{1}, "zigbee", "00124b0010000000"};
    message.body = model::Actuate{1, {Kind::kActuator, types_.find("switch")->id, "1"}, false, 10s};
    ASSERT_TRUE(supervisor_->send(message));
    EXPECT_TRUE(machine_->until([&] {
      return std::any_of(said_.begin(), said_.end(), [&](const Message& one) {
        const auto* updates = std::get_if<model::Updates>(&one.body);
        return updates != nullptr &&
               std::any_of(updates->readings.begin(), updates->readings.end(), [&](const auto& reading) {
                 return reading.point.kind == Kind::kActuator && reading.value == Value(false);
               });
      });
    }));
    EXPECT_EQ(count<model::Acknowledge>(), 1U);
  }

  support::PrivateNetwork own_network_;
  std::string folder_;
  std::unique_ptr<transport::MachineWorld> machine_;
  support::CollectingLog words_;
  TypeCatalogue types_;
  ConfigNode options_;
  ConfigErrors errors_;
  std::vector<Message> said_;
  std::unique_ptr<Mosquitto> broker_;
  std::unique_ptr<zigbee_simulator::World> world_;
  std::unique_ptr<zigbee_simulator::BrokerLine> bridge_;
  std::unique_ptr<network::Supervisor> supervisor_;
};

TEST_F(OnMosquitto, DevicesJoinAndObeyInBothVersionsOfMqtt) {
  begin_broker({});
  begin_bridge({});
  for (const auto* version : {"3.1.1", "5"}) {
    said_.clear();
    begin_network({{"host", "127.0.0.1"}, {"version", version}});
    expect_a_whole_command();
    world_->radio().change(*world_->registry().find("plug"), "state", "ON");
  }
}

TEST_F(OnMosquitto, WithTlsAndAPassword) {
  const Certificates certificates;
  if (!certificates.reason().empty()) GTEST_SKIP() << certificates.reason();
  MosquittoOptions secured;
  secured.tls = &certificates;
  secured.users = {{"rubicon", "right"}};
  begin_broker(secured);
  transport::MqttOptions at;
  at.user = "rubicon";
  at.password = "right";
  at.tls = transport::MqttTls{certificates.path("ca.pem"), {}, {}, "broker.test"};
  begin_bridge(at);
  begin_network({{"host", "127.0.0.1"},
                 {"port", 1883},
                 {"tls", {{"ca", certificates.path("ca.pem")}, {"server-name", "broker.test"}}},
                 {"user", "rubicon"},
                 {"password-file", secret("right")}});
  expect_a_whole_command();
}

/// The island may read everything and write nothing: mosquitto drops what it publishes, and says so in version 5.
TEST_F(OnMosquitto, ACommandThatTheAccessListForbidsIsRefused) {
  MosquittoOptions closed;
  closed.users = {{"rubicon", "right"}, {"bridge", "its own"}};
  closed.acl = "user rubicon\ntopic read zigbee2mqtt/#\nuser bridge\ntopic readwrite #\n";
  begin_broker(closed);
  transport::MqttOptions at;
  at.user = "bridge";
  at.password = "its own";
  begin_bridge(at);
  begin_network({{"host", "127.0.0.1"}, {"version", "5"}, {"user", "rubicon"}, {"password-file", secret("right")}});
  ASSERT_TRUE(machine_->until([&] { return is(model::LineState::kUp) && count<model::Join>() == 2; }));
  Message message;
  message.destination = {IslandId{1}, "zigbee", "00124b0010000000"};
  message.body = model::Actuate{1, {Kind::kActuator, types_.find("switch")->id, "1"}, false, 10s};
  ASSERT_TRUE(supervisor_->send(message));
  const model::Acknowledge* answer = nullptr;
  EXPECT_TRUE(machine_->until([&] {
    for (const auto& one : said_)
      if (const auto* found = std::get_if<model::Acknowledge>(&one.body)) answer = found;
    return answer != nullptr;
  }));
  ASSERT_NE(answer, nullptr);
  EXPECT_EQ(answer->outcome, model::Outcome::kRefused);
  EXPECT_THAT(answer->text, HasSubstr("0x87"));
}

TEST_F(OnMosquitto, AWrongPasswordIsARefusalWithoutTheSecret) {
  MosquittoOptions closed;
  closed.users = {{"rubicon", "right"}};
  begin_broker(closed);
  begin_network({{"host", "127.0.0.1"}, {"user", "rubicon"}, {"password-file", secret("wr0ng-secret")}});
  ASSERT_TRUE(machine_->until([&] { return is(model::LineState::kRefused); }));
  for (const auto& line : words_.lines) EXPECT_THAT(line, Not(HasSubstr("wr0ng-secret")));
  for (const auto& message : said_) {
    const auto* state = std::get_if<model::State>(&message.body);
    if (state != nullptr) {
      EXPECT_THAT(state->reason, Not(HasSubstr("wr0ng-secret")));
    }
  }
}

TEST_F(OnMosquitto, AfterADeathOfTheBrokerItIsBackAndNoDeviceJoinsAgain) {
  begin_broker({});
  begin_bridge({});
  begin_network("127.0.0.1");
  expect_a_whole_command();
  for (int death = 0; death < 3; ++death) {
    broker_->kill();
    ASSERT_TRUE(machine_->until([&] { return is(model::LineState::kDown); }));
    broker_->start();
    ASSERT_TRUE(machine_->until([&] { return is(model::LineState::kUp); }));
  }
  EXPECT_EQ(count<model::Join>(), 2U);
  EXPECT_EQ(count<model::Leave>(), 0U);
}

}  // namespace
}  // namespace rubicon::networks::zigbee
