#include "apps/rubicon/output/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace rubicon::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Kind = Column::Kind;

std::size_t longest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);) longest = std::max(longest, characters(line));
  return longest;
}

/// As `rubicon ls` shows it.
Table listing(const std::string& value = "412.7") {
  Table table({{"TUPLE", Kind::kKey}, {"VALUE", Kind::kValue}, {"QUALITY", Kind::kWord, 1}, {"AGE", Kind::kWord, 2}});
  table.row({"6541:proxy.dummy-rooms.living.sensor.illuminance-1.value", value, "device-offline", "12min"});
  table.row({"6541:proxy.dummy-rooms.bath.sensor.temperature-1.value", "21.5", "good", "0.3s"});
  return table;
}

/// As `rubicon devices` shows it.
Table devices() {
  Table table({{"DEVICE", Kind::kKey},
               {"NAME", Kind::kText, 2},
               {"STATUS", Kind::kText},
               {"TYPE", Kind::kText, 3},
               {"SENSORS", Kind::kText, 1},
               {"ACTUATORS", Kind::kText, 1}});
  table.row({"6541:proxy.dummy-rooms.living", "Living room", "unreachable: silent for 60s", "simulated",
             "temperature-1 illuminance-1 motion-1", "lamp-1 lamp-2 blind-1"});
  return table;
}

TEST(Layout, EachWidthShowsEveryValue) {
  for (const std::size_t width : {40U, 60U, 80U, 120U}) {
    const auto text = listing().text({false, width});
    EXPECT_LE(longest_line(text), width) << text;
    EXPECT_THAT(text, HasSubstr("412.7"));
    EXPECT_THAT(text, HasSubstr("21.5"));
  }
}

TEST(Layout, OfEightyColumnsShortensKeysInTheMiddle) {
  EXPECT_EQ(listing().text({false, 80}),
            "TUPLE                                               VALUE  QUALITY         AGE\n"
            "6541:proxy.dummy…living.sensor.illuminance-1.value  412.7  device-offline  12min\n"
            "6541:proxy.dummy…s.bath.sensor.temperature-1.value  21.5   good            0.3s\n");
}

TEST(Layout, OfAHundredAndTwentyColumnsShowsAllAsItIs) {
  EXPECT_EQ(listing().text({false, 120}), listing().text({}));
  EXPECT_THAT(devices().text({false, 120}), Not(HasSubstr("…")));
}

TEST(Layout, AColumnIsNeverLeftOutUnmarked) {
  const auto text = listing().text({false, 40});
  EXPECT_THAT(text, HasSubstr("… AGE left out"));
  EXPECT_THAT(text, Not(HasSubstr("12min")));
  EXPECT_THAT(text, HasSubstr("device-offline"));
}

TEST(Layout, ListsAndReasonsAreWrapped) {
  const auto text = devices().text({false, 80});
  EXPECT_LE(longest_line(text), 80U) << text;
  for (const auto* word : {"temperature-1", "illuminance-1", "motion-1", "lamp-1", "lamp-2", "blind-1",
                           "unreachable:", "silent for", "60s"})
    EXPECT_THAT(text, HasSubstr(word)) << text;
}

TEST(Layout, AValueThatIsLongerThanTheScreenIsWrappedNotCut) {
  const std::string json = R"({"name":"Living","sensors":["temperature-1","illuminance-1"],"actuators":["lamp-1"]})";
  const auto text = listing(json).text({false, 80});
  EXPECT_LE(longest_line(text), 80U) << text;
  std::string shown;
  Table alone({{"VALUE", Kind::kValue}});
  alone.row({json});
  std::istringstream lines(alone.text({false, 20}));
  for (std::string line; std::getline(lines, line);) shown += line;
  EXPECT_EQ(shown, "VALUE" + json);
}

TEST(Layout, ShortensInTheMiddleByCharacters) {
  EXPECT_EQ(shortened("living", 6), "living");
  EXPECT_EQ(shortened("0123456789", 7), "01…6789");
  EXPECT_EQ(shortened("Küche-Küche", 7), "Kü…üche");
  EXPECT_EQ(shortened("abc", 1), "…");
}

TEST(Layout, WrapsAtBlanksAndBars) {
  EXPECT_THAT(wrapped("one two three", 7), ElementsAre("one two", "three"));
  EXPECT_THAT(wrapped("off|on|auto", 7), ElementsAre("off|on|", "auto"));
  EXPECT_THAT(wrapped("0123456789", 4), ElementsAre("0123", "4567", "89"));
  EXPECT_THAT(wrapped("", 4), ElementsAre(""));
  EXPECT_THAT(wrapped("as long as it is", 0), ElementsAre("as long as it is"));
}

}  // namespace
}  // namespace rubicon::cli
