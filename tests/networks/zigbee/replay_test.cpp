#include <fstream>
#include <map>
#include <set>

#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using model::LineState;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// What a real Zigbee2MQTT 2.14.1 published: 16 joins with interviews, reports, two sets, one leave, a clean stop.
/// Labels, descriptions and the bridge's own settings are left out.
class ZigbeeReplay : public House {
 protected:
  struct Line {
    double at = 0;  ///< seconds since the first one
    std::string topic, payload;
  };

  /// Each `{"same": n}` in the file is its n-th part.
  static json with(const std::vector<json>& parts, json value) {
    if (value.is_object() && value.size() == 1 && value.contains("same")) return parts.at(value["same"]);
    if (value.is_structured()) {
      for (auto& item : value) item = with(parts, item);
    }
    return value;
  }

  void SetUp() override {
    std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/zigbee/sixteen_devices.jsonl");
    ASSERT_TRUE(file);
    std::vector<json> parts;
    for (std::string text; std::getline(file, text);) {
      auto line = json::parse(text);
      if (line.contains("part")) {
        parts.push_back(with(parts, line["part"]));
        continue;
      }
      const auto payload = with(parts, line["payload"]);
      trace_.push_back({line["at"], line["topic"], payload.is_string() ? payload.get<std::string>() : payload.dump()});
    }
    // 2026-11-21T00:16:31.822Z: the times of the trace are those of the host.
    host.time.set_wall(WallTime(std::chrono::microseconds(1795220191822421)));
    make();
    open();
  }
  /// `factor` of the recorded pauses.
  void play(double factor) {
    double now = 0;
    for (const auto& line : trace_) {
      host.time.run_for(std::chrono::duration_cast<Duration>(std::chrono::duration<double>((line.at - now) * factor)));
      now = line.at;
      broker.publish(line.topic, line.payload,
                     line.topic.find("/bridge/") != line.topic.npos && line.topic.find("/event") == line.topic.npos);
      host.time.run_for(1ms);
    }
    host.time.run_for(1s);
  }
  void expect_the_end() {
    std::set<std::string> joined;
    for (const auto& [device, join] : host.all<model::Join>()) {
      if (join.problem.empty() && !joined.contains(device)) joined.insert(device);
    }
    EXPECT_THAT(joined, SizeIs(16));
    const auto leaves = host.all<model::Leave>();
    ASSERT_THAT(leaves, SizeIs(1));
    EXPECT_EQ(leaves[0].first, "00124b0010000005");
    EXPECT_EQ(state().line, LineState::kDown);
    EXPECT_EQ(state().counters.at("joins"), 16U);
    EXPECT_EQ(state().counters.at("unreadable-messages"), 0U);
    EXPECT_EQ(state().counters.at("unreadable-states"), 0U);
    EXPECT_EQ(state().counters.at("unreadable-lists"), 0U);
    EXPECT_EQ(state().counters.at("sets"), 0U) << "the two of the trace are those of another client";
    EXPECT_THAT(host.failures, IsEmpty());
  }
  std::vector<Line> trace_;
};

TEST_F(ZigbeeReplay, AtItsOwnSpeedSixteenDevicesJoinAndReportAndOneLeaves) {
  play(1);
  expect_the_end();
  // Another client set a lamp: the island asks it for its state, and no device answers here.
  EXPECT_THAT(gets("0x00124b0010000000"), Not(IsEmpty()));
  EXPECT_GT(readings(), 50U);
  for (const auto& message : host.delivered) {
    const auto* updates = std::get_if<model::Updates>(&message.body);
    if (updates == nullptr) continue;
    for (const auto& reading : updates->readings) {
      EXPECT_EQ(reading.why, "");
      EXPECT_LE(reading.user_time, host.time.wall_now());
    }
  }
}

TEST_F(ZigbeeReplay, AsFastAsItGoesTheEndIsTheSame) {
  play(0);
  expect_the_end();
}

}  // namespace
}  // namespace rubicon::networks::zigbee
