#include "config/service_config.h"

#include <gmock/gmock.h>

#include "config/yaml.h"

namespace rubicon::config {
namespace {

using testing::HasSubstr;

std::vector<BridgeSetup> bridges_of(const std::string& text, base::ConfigErrors& errors) {
  const auto root = parse_yaml(text, "home.yaml");
  EXPECT_TRUE(root);
  ConfigReader reader(root.value(), "", errors);
  return read_bridges(reader);
}

TEST(BridgeConfig, ReadsNameTypeAndKeepsTheOptionsForTheType) {
  base::ConfigErrors errors;
  const auto setups = bridges_of("bridges: {ha: {type: mqtt, broker: localhost}, db: {type: mqtt}}\n", errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  ASSERT_EQ(setups.size(), 2U);
  EXPECT_EQ(setups[0].name, "ha");
  EXPECT_EQ(setups[0].type, "mqtt");
  EXPECT_EQ(setups[0].options.find("broker")->text, "localhost");
}

TEST(BridgeConfig, TwoAreEqualIfTheirOptionsAreWhereverTheyStand) {
  base::ConfigErrors errors;
  const auto one = bridges_of("bridges: {ha: {type: mqtt, broker: a}}\n", errors);
  const auto same = bridges_of("\n\nbridges:\n  ha:\n    type: mqtt\n    broker: a\n", errors);
  const auto other = bridges_of("bridges: {ha: {type: mqtt, broker: b}}\n", errors);
  EXPECT_EQ(one, same);
  EXPECT_NE(one, other);
}

TEST(BridgeConfig, SaysWhatIsWrongWithItsPlace) {
  base::ConfigErrors errors;
  std::ignore = bridges_of("bridges: {'a b': {type: mqtt}, c: {}}\n", errors);
  EXPECT_THAT(errors.text(), HasSubstr("home.yaml:1:"));
  EXPECT_THAT(errors.text(), HasSubstr("a bridge's name has"));
  EXPECT_THAT(errors.text(), HasSubstr("'type' is missing"));
}

}  // namespace
}  // namespace rubicon::config
