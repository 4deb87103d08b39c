#include <fstream>

#include "simulators/zigbee/simulated_bridge.h"

// Compares the world with the trace of a real Zigbee2MQTT 2.14.1 beside the source tree.
namespace rubicon::zigbee_simulator {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

const std::string kTrace = RUBICON_SOURCE_DIR "/../shared/data/zigbee/trace16-small.jsonl";
constexpr std::string_view kLamp = "0x00124b0010000000";

class RecordedOrder : public SimulatedBridge {
 protected:
  void SetUp() override {
    std::ifstream file(kTrace);
    if (!file) GTEST_SKIP() << "no ../shared/data/zigbee/trace16-small.jsonl beside the source tree";
    for (std::string line; std::getline(file, line);) {
      const auto entry = Json::parse(line);
      const auto topic = entry["topic"].get<std::string>();
      recorded.push_back({topic.substr(topic.find('/') + 1), entry["payload"].dump(), false});
    }
    ASSERT_EQ(recorded.size(), 452U);
  }

  static std::string keys(const Json& object) {
    std::string all;
    for (const auto& [key, value] : object.items()) all += " " + key;
    return all;
  }
  /// What a message is: its topic and the members of its payload.
  static std::string form(const Published& one) {
    const auto payload = one.json();
    if (one.topic == "bridge/info") return one.topic;
    if (payload.is_array()) return one.topic + keys(payload.empty() ? Json::object() : payload.back());
    if (one.topic != "bridge/event") return one.topic + keys(payload);
    return one.topic + " " + payload["type"].get<std::string>() + keys(payload["data"]) + " " +
           payload["data"].value("status", "");
  }
  static std::vector<std::string> forms(const std::vector<Published>& published) {
    std::vector<std::string> all;
    for (const auto& one : published) all.push_back(form(one));
    return all;
  }
  std::vector<Published> slice(std::size_t first, std::size_t last) const {
    return {recorded.begin() + static_cast<std::ptrdiff_t>(first) - 1,
            recorded.begin() + static_cast<std::ptrdiff_t>(last)};
  }
  static std::vector<Published> only(const std::vector<Published>& published, std::string_view topic) {
    std::vector<Published> all;
    std::ranges::copy_if(published, std::back_inserter(all), [&](auto& one) { return one.topic == topic; });
    return all;
  }
  std::size_t first(const std::vector<Published>& in, std::string_view wanted) {
    const auto found = std::ranges::find_if(in, [&](auto& one) { return form(one).find(wanted) != std::string::npos; });
    return static_cast<std::size_t>(found - in.begin()) + 1;
  }
  void join_a_lamp() {
    make();
    world->join(find_model("lamp").value());
    start();
    ask("bridge/request/permit_join", R"({"time":60})");
    time.run_for(3s);
  }

  std::vector<Published> recorded;
};

TEST_F(RecordedOrder, TheStart) {
  make();
  world->start();
  auto start = slice(1, 6);
  EXPECT_EQ(forms(published), forms(start));
}

TEST_F(RecordedOrder, AJoinUntilTheInterviewBegins) {
  join_a_lamp();
  // lines 8 to 15: info, response, availability, heard, twice the list, two events
  published.resize(8);
  EXPECT_EQ(forms(published), forms(slice(8, 15)));
}

TEST_F(RecordedOrder, TheInterviewIsHeardAsOftenAndEndsWithListAndEvent) {
  join_a_lamp();
  const auto end = first(published, "successful"), recorded_end = first(recorded, "successful");
  EXPECT_EQ(forms(only({published.begin(), published.begin() + static_cast<std::ptrdiff_t>(end)}, kLamp)),
            forms(only(slice(1, recorded_end), kLamp)));
  EXPECT_EQ(form(published[end - 1]), form(recorded[recorded_end - 1]));
  EXPECT_EQ(published[end - 2].topic, recorded[recorded_end - 2].topic) << "the list before its event";
  const auto definition = published[end - 1].json()["data"]["definition"];
  EXPECT_EQ(keys(definition), keys(recorded[recorded_end - 1].json()["data"]["definition"]));
}

TEST_F(RecordedOrder, TheRecordOfAnInterviewedDevice) {
  join_a_lamp();
  const auto lists = only(recorded, "bridge/devices");
  const auto record = lists.back().json()[1];
  ASSERT_EQ(record["ieee_address"], kLamp);
  const auto ours = of("bridge/devices").back()[1];
  EXPECT_EQ(keys(ours), keys(record));
  for (const auto* same : {"ieee_address", "friendly_name", "type", "model_id", "manufacturer", "power_source",
                           "interview_state", "supported", "disabled", "network_address"})
    EXPECT_EQ(ours[same], record[same]) << same;
  EXPECT_EQ(of("bridge/devices").size(), 4U) << "about four lists a join";
}

TEST_F(RecordedOrder, ASet) {
  join_a_lamp();
  published.clear();
  ask(std::string(kLamp) + "/set", R"({"state": "ON", "brightness": 40})");
  time.run_for(1s);
  const auto wanted = slice(413, 416);  // heard, echo, two reports
  EXPECT_EQ(forms(published), forms(wanted));
  const auto with_time_of = [](const std::vector<Published>& messages, std::size_t one, std::size_t other) {
    return messages[one].json()["last_seen"] == messages[other].json()["last_seen"];
  };
  for (std::size_t i = 0; i + 1 < wanted.size(); ++i)
    EXPECT_EQ(with_time_of(published, i, i + 1), with_time_of(wanted, i, i + 1)) << i;
}

TEST_F(RecordedOrder, AReport) {
  make();
  auto& plug = add("plug", "0x00124b0010000002");
  start();
  world->radio().change(plug, "power", 77);
  EXPECT_EQ(forms(published), forms(slice(419, 419)));
}

TEST_F(RecordedOrder, ALeave) {
  make();
  const auto address = add("plug", "").address();
  start();
  world->leave(address);
  const auto wanted = slice(433, 435);
  ASSERT_EQ(published.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(published[i].topic, wanted[i].topic);
  EXPECT_EQ(form(published[2]), form(wanted[2]));
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
