#include "config/storage_config.h"

#include <gmock/gmock.h>

#include "config/yaml.h"

namespace rubicon::config {
namespace {

using testing::HasSubstr;

std::optional<HistorySetup> read_past(const std::string& section, base::ConfigErrors& errors) {
  auto root = parse_yaml("a: 1\nhistory: " + section + "\n", "home.yaml");
  EXPECT_TRUE(root);
  if (!root) return std::nullopt;
  ConfigReader reader(*root, "", errors);
  return read_history(reader);
}

HistorySetup good_history(const std::string& section) {
  base::ConfigErrors errors;
  auto setup = read_past(section, errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  return setup.value_or(HistorySetup{});
}

std::string wrong_history(const std::string& section) {
  base::ConfigErrors errors;
  std::ignore = read_past(section, errors);
  return errors.text();
}

TEST(HistoryConfig, WithoutTheSectionThereIsNone) {
  auto root = parse_yaml("a: 1\n", "home.yaml");
  ASSERT_TRUE(root);
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  EXPECT_FALSE(read_history(reader));
}

TEST(HistoryConfig, NeedsOnlyItsFile) {
  HistorySetup expected;
  expected.file = "home.history";
  EXPECT_EQ(good_history("{file: home.history}"), expected);
  ASSERT_EQ(expected.patterns.size(), 1U);
  EXPECT_TRUE(expected.patterns[0].matches(OwnerId(7), "proxy.wsn-1.7.sensor.light-1.value"));
  EXPECT_FALSE(expected.patterns[0].matches(OwnerId(7), "proxy.wsn-1.7.sensor.light-1.status"));
}

TEST(HistoryConfig, ReadsAllKeys) {
  const auto setup = good_history(
      "{file: h, patterns: [\"7:proxy.**\"], exclude: [\"*:*.*.*.sensor.motion-1.value\"], minimum: 5s, deadband: 0.5, "
      "raw: never, hours: 365d, size: 2GB}");
  ASSERT_EQ(setup.patterns.size(), 1U);
  EXPECT_EQ(setup.patterns[0].owner, OwnerId(7));
  EXPECT_EQ(setup.exclude.size(), 1U);
  EXPECT_EQ(setup.minimum, std::chrono::seconds(5));
  EXPECT_EQ(setup.dead_band, 0.5);
  EXPECT_FALSE(setup.raw);
  EXPECT_EQ(setup.hours, std::chrono::hours(365 * 24));
  EXPECT_EQ(setup.size, 2'000'000'000U);
}

TEST(HistoryConfig, NamesWhatIsWrong) {
  EXPECT_THAT(wrong_history("{}"), HasSubstr("history"));
  EXPECT_THAT(wrong_history("{file: \"\"}"), HasSubstr("empty path"));
  EXPECT_THAT(wrong_history("{file: h, patterns: []}"), HasSubstr("is empty"));
  EXPECT_THAT(wrong_history("{file: h, patterns: [\"a..b\"]}"), HasSubstr("home.yaml:2"));
  EXPECT_THAT(wrong_history("{file: h, raw: 5min}"), HasSubstr("at least 1h"));
  EXPECT_THAT(wrong_history("{file: h, size: 10kB}"), HasSubstr("1MB"));
  EXPECT_THAT(wrong_history("{file: h, pattern: x}"), HasSubstr("patterns"));
}

}  // namespace
}  // namespace rubicon::config
