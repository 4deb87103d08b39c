#include "apps/simulators/motes/script.h"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "apps/simulators/motes/sensors.h"

namespace rubicon::motes_simulator {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = Step::Kind;

Step one(std::string_view line) {
  const auto steps = parse_script(line);
  EXPECT_TRUE(steps) << steps.error().text;
  return steps && steps->size() == 1 ? steps->front() : Step{};
}

std::string refused(std::string_view text) {
  const auto steps = parse_script(text);
  return steps ? "taken" : steps.error().text;
}

TEST(MoteScript, ReadsEachKindOfLine) {
  EXPECT_EQ(one("at 2s reboot 7"), (Step{2s, Kind::kReboot, {7, 0}, {}, 0, 0, 0, {}}));
  EXPECT_EQ(one("at 2s reboot all over 4s"), (Step{2s, Kind::kReboot, {}, {}, 0, 0, 0, 4s}));
  EXPECT_EQ(one("at 3s kill 7@2"), (Step{3s, Kind::kKill, {7, 2}, {}, 0, 0, 0, {}}));
  EXPECT_EQ(one("at 4s move 7 to 2,1"), (Step{4s, Kind::kMove, {7, 0}, {2, 1}, 0, 0, 0, {}}));
  EXPECT_EQ(one("at 4s move all to none"), (Step{4s, Kind::kMove, {}, {}, 0, 0, 0, {}}));
  EXPECT_EQ(one("at 5s stall 7"), (Step{5s, Kind::kStall, {7, 0}, {}, 0, 0, 0, {}}));
  EXPECT_EQ(one("at 6s set 7 light 500"), (Step{6s, Kind::kSet, {7, 0}, {}, kLightSensor, 0, 500, {}}));
  EXPECT_EQ(one("at 6s ramp 7 temperature 6500 7000 over 60s"),
            (Step{6s, Kind::kRamp, {7, 0}, {}, kTemperatureSensor, 6500, 7000, 60s}));
  EXPECT_EQ(one("at 6s sine all rssi5 9 1 every 5min"), (Step{6s, Kind::kSine, {}, {}, 14, 9, 1, 5min}));
  EXPECT_EQ(one("at 6s walk 7 humidity 1 2 every 2s").kind, Kind::kWalk);
  EXPECT_EQ(one("at 6s count 7 light").kind, Kind::kCount);
  EXPECT_EQ(one("at 10s loss 20"), (Step{10s, Kind::kLoss, {}, {}, 0, 0, 0.2, {}}));
  EXPECT_EQ(one("at 10s loss 20 of 7"), (Step{10s, Kind::kLossOf, {7, 0}, {}, 0, 0, 0.2, {}}));
  EXPECT_EQ(one("at 10s duplicates 100").to, 1);
  EXPECT_EQ(one("at 10s delay 30ms").span, 30ms);
  EXPECT_EQ(one("at 10s sink-reboot 1").sinks, std::vector<std::uint16_t>{1});
  EXPECT_EQ(one("at 12s unplug 1 for 5s"), (Step{12s, Kind::kUnplug, {}, {1}, 0, 0, 0, 5s}));
  EXPECT_EQ(one("  at 60s  repeat # all of it").kind, Kind::kRepeat);
}

TEST(MoteScript, SortsByTimeAndSkipsCommentsAndEmptyLines) {
  const auto steps = parse_script("# begins\n\nat 5s kill 7\r\nat 1s reboot 7\nat 5s reboot 8");
  ASSERT_TRUE(steps);
  EXPECT_THAT(*steps, ElementsAre(one("at 1s reboot 7"), one("at 5s kill 7"), one("at 5s reboot 8")));
  EXPECT_THAT(parse_script("").value(), IsEmpty());
}

TEST(MoteScript, SaysWhereAndWhatWasExpected) {
  EXPECT_THAT(refused("at 1s kill 7\nat 2s kill"), HasSubstr("line 2: "));
  EXPECT_THAT(refused("at 2s kill"), ::testing::EndsWith("expected one of: 'at SPAN kill MOTE'"));
  EXPECT_THAT(refused("explode"), ::testing::AllOf(HasSubstr("'at SPAN reboot MOTE'"), HasSubstr("'at SPAN repeat'")));
  EXPECT_THAT(refused("at 0s repeat"), HasSubstr("at least 1ms"));
  EXPECT_EQ(refused("at 5s repeat\nat 1s kill 7\n\nat 9s kill 8"),
            "line 4: is never reached, expected a time before 'repeat'");
  EXPECT_THAT(refused("at 5s repeat\nat 9s repeat"), HasSubstr("line 2: is never reached"));
  EXPECT_THAT(refused("at 0s ramp 7 light 1 2 over 0s"), HasSubstr("at least 1ms"));
  for (const auto* bad :
       {"at 1 kill 7", "at -1s kill 7", "at 1s kill 0", "at 1s kill 70000", "at 1s kill 7@", "at 1s kill @1",
        "at 1s move 7 to 1,,2", "at 1s move 7 to 1,", "at 1s set 7 colour 1", "at 1s set 7 light -1",
        "at 1s set 7 light 65536", "at 1s set 7 light nan", "at 1s loss 101", "at 1s loss 5%", "at 1s unplug 1",
        "at 1s move 7 to 1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17"})
    EXPECT_NE(refused(bad), "taken") << bad;
}

TEST(MoteScript, OfTheExampleIsGood) {
  std::ifstream file(RUBICON_SOURCE_DIR "/examples/motes.script");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto steps = parse_script(text);
  ASSERT_TRUE(steps) << steps.error().text;
  EXPECT_GT(steps->size(), 10u);
}

}  // namespace
}  // namespace rubicon::motes_simulator
