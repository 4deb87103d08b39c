#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "device_support.h"
#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/device/state_message.h"

namespace rubicon::networks::zigbee {
namespace {

using nlohmann::json;

const std::string kData = RUBICON_SOURCE_DIR "/../shared/data/zigbee/";

struct Line {
  WallTime at{};
  std::string topic, payload;
};

/// The state and set messages of the recorded trace.
std::vector<Line> read_trace() {
  std::vector<Line> lines;
  std::ifstream file(kData + "trace16-small.jsonl");
  for (std::string text; std::getline(file, text);) {
    const auto tree = json::parse(text);
    auto time = tree.at("tst").get<std::string>();
    time.resize(time.size() - std::string_view("+0000").size());
    lines.push_back({device::read_last_seen("\"" + time + "\"").value(), tree.at("topic").get<std::string>(),
                     tree.at("payload").dump()});
  }
  return lines;
}

/// The devices of the list, as Zigbee2MQTT 2.14.1 published it.
class ReplayTest : public testing::Test {
 protected:
  struct OneDevice {
    FakeDeviceHost host;
    std::unique_ptr<Device> device;
    std::string last;  ///< state message
    std::size_t answered = 0;
  };

  void SetUp() override {
    trace_ = read_trace();
    if (trace_.empty()) GTEST_SKIP() << "no ../shared/data/zigbee beside the source tree";
    std::ifstream file(kData + "bridge_devices.json");
    for (const auto& tree : json::parse(file)) {
      auto record = bridge::read_device_record(tree.dump());
      ASSERT_TRUE(record) << record.error().text;
      if (record->role == bridge::Role::kCoordinator) continue;
      auto& one = devices_[record->name];
      one.host.time.set_wall(trace_.front().at - seconds(20));
      one.device = std::make_unique<Device>(one.host, models_, std::move(*record));
      one.device->line_up();
      one.host.time.run_for(seconds(20));
      one.host.delivered.clear();
      one.host.published.clear();
    }
  }

  void advance(OneDevice& one, WallTime to) {
    while (one.host.time.wall_now() < to) {
      one.host.time.run_for(std::min<Duration>(to - one.host.time.wall_now(), milliseconds(10)));
      if (answers_gets_) answer_gets(one);
    }
  }
  /// As a device that executes its commands: the values of the last message, with a new last_seen.
  static void answer_gets(OneDevice& one) {
    const auto asked = one.host.payloads("get").size();
    if (std::exchange(one.answered, asked) == asked || one.last.empty()) return;
    auto tree = json::parse(one.last);
    tree["last_seen"] = iso(one.host.time.wall_now());
    ASSERT_TRUE(one.device->state(tree.dump(), false));
  }
  void replay() {
    for (const auto& line : trace_) {
      const auto name = line.topic.substr(line.topic.find('/') + 1);
      const auto found = devices_.find(name.substr(0, name.find('/')));
      if (found == devices_.end()) continue;
      advance(found->second, line.at);
      if (name.ends_with("/set"))
        set(found->second, json::parse(line.payload));
      else if (name == found->first)
        state(found->second, line.payload);
    }
    for (auto& [name, one] : devices_) advance(one, one.host.time.wall_now() + seconds(5));
  }
  void state(OneDevice& one, const std::string& payload) {
    one.last = payload;
    const auto done = one.device->state(payload, false);
    EXPECT_TRUE(done) << done.error().text;
    ++states_;
  }
  virtual void set(OneDevice& one, const json& values) {
    if (!commands_) return;
    for (const auto& [key, value] : values.items()) {
      for (const auto& point : one.device->points()) {
        if (point.property != key) continue;
        Message message;
        message.body = model::Actuate{++request_, point.capability.point, exposes::decode(point, value.dump()).value(),
                                      seconds(5)};
        EXPECT_TRUE(one.device->send(message));
      }
    }
    one.host.time.run_ready();
  }
  static std::string property_of(const OneDevice& one, const PointId& id) {
    for (const auto& point : one.device->points()) {
      if (point.capability.point == id) return point.property;
    }
    return "?";
  }

  TypeCatalogue types_;
  exposes::PointsOfModels models_{types_};
  std::map<std::string, OneDevice> devices_;
  std::vector<Line> trace_;
  bool answers_gets_ = false, commands_ = false;
  std::size_t states_ = 0;
  std::uint64_t request_ = 0;
};

// Of 297 messages 210 bring nothing but last_seen and linkquality: 194, and the first of each of the 16 devices. The
// numbers were counted by a program of a few lines in another language. Echoes of the two sets of another client are
// not among them, because no device answers our questions here.
TEST_F(ReplayTest, OfTheRecordedMessagesOnlyTheChangesAreReadings) {
  replay();
  EXPECT_EQ(devices_.size(), 16U);
  EXPECT_EQ(states_, 297U);
  std::map<std::string, int> readings;
  std::size_t alive = 0, with_news = 0;
  for (const auto& [name, one] : devices_) {
    alive += one.host.all<model::KeepAlive>().size();
    for (const auto& updates : one.host.all<model::Updates>()) {
      EXPECT_TRUE(updates.heard);
      bool news = false;
      for (const auto& reading : updates.readings) {
        const auto property = property_of(one, reading.point);
        ++readings[property];
        news |= property != "linkquality";
        EXPECT_NE(reading.value, Value()) << property;
        EXPECT_NE(reading.user_time, WallTime{});
      }
      with_news += news;
    }
  }
  const std::map<std::string, int> expected{{"linkquality", 240}, {"state", 4},        {"voltage", 4},
                                            {"current", 2},       {"power", 12},       {"battery", 2},
                                            {"energy", 2},        {"temperature", 21}, {"humidity", 23},
                                            {"illuminance", 12},  {"occupancy", 2},    {"contact", 7}};
  EXPECT_EQ(readings, expected);
  EXPECT_EQ(alive, 18U);
  EXPECT_EQ(with_news, 297U - 210U - 2U);  // two of the others are the echoes
}

TEST_F(ReplayTest, TheRecordedSetsAsOurCommandsAreConfirmedByTheAnswersToOurGets) {
  answers_gets_ = commands_ = true;
  replay();
  auto& plug = devices_.at("0x00124b0010000002");
  auto& lamp = devices_.at("0x00124b0010000000");
  EXPECT_EQ(plug.host.payloads("set"), std::vector<std::string>{R"({"state":"OFF"})"});
  EXPECT_EQ(lamp.host.payloads("set"), std::vector<std::string>{R"({"brightness":40,"state":"ON"})"});
  for (const auto* one : {&plug, &lamp}) {
    for (const auto& answer : one->host.all<model::Acknowledge>()) EXPECT_EQ(answer.outcome, model::Outcome::kSent);
  }
  EXPECT_EQ(plug.host.all<model::Acknowledge>().size(), 1U);
  EXPECT_EQ(lamp.host.all<model::Acknowledge>().size(), 2U);
  std::map<std::string, Value> shown;
  for (const auto& updates : lamp.host.all<model::Updates>()) {
    for (const auto& reading : updates.readings) shown[property_of(lamp, reading.point)] = reading.value;
  }
  EXPECT_EQ(shown.at("state"), Value(true));
  EXPECT_NEAR(std::get<double>(shown.at("brightness")), 15.7, 1e-9);
}

}  // namespace
}  // namespace rubicon::networks::zigbee
