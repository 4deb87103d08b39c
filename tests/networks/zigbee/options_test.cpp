#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/zigbee/zigbee_options.h"
#include "support/config_text.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::HasSubstr;

struct ReadOptions {
  explicit ReadOptions(const char* json) : node(support::config_of(std::string_view(json))) {
    ConfigReader reader(node, "networks.zigbee", errors);
    options = read_zigbee_options({"zigbee", IslandId{1}, reader, types, {}});
    reader.finish();
  }
  ConfigNode node;
  ConfigErrors errors;
  TypeCatalogue types;
  ZigbeeOptions options;
};

TEST(ZigbeeOptionsTest, ABrokerIsEnough) {
  const ReadOptions read(R"({"broker": "broker.lan"})");
  EXPECT_EQ(read.errors.text(), "");
  EXPECT_EQ(read.options.broker.line.host, "broker.lan");
  EXPECT_EQ(read.options.broker.line.port, 1883);
  EXPECT_EQ(read.options.base, "zigbee2mqtt");
  EXPECT_EQ(read.options.polls_per_second, 10U);
}

TEST(ZigbeeOptionsTest, EveryErrorIsReportedAtOnce) {
  const ReadOptions read(R"({"base": "a/#", "polls-per-second": 0, "strange": 1})");
  EXPECT_THAT(read.errors.text(), HasSubstr("broker"));
  EXPECT_THAT(read.errors.text(), HasSubstr("base"));
  EXPECT_THAT(read.errors.text(), HasSubstr("polls-per-second"));
  EXPECT_THAT(read.errors.text(), HasSubstr("strange"));
}

TEST(ZigbeeOptionsTest, ALineIsTheSameIfNothingOfItChanged) {
  const ReadOptions one(R"({"broker": {"host": "b", "user": "u", "password-env": "P"}})");
  const ReadOptions same(R"({"broker": {"host": "b", "user": "u", "password-env": "P"}, "polls-per-second": 3})");
  const ReadOptions other(R"({"broker": {"host": "b", "user": "v", "password-env": "P"}})");
  const ReadOptions secure(
      R"({"broker": {"host": "b", "user": "u", "password-env": "P", "tls": "yes", "port": 1883}})");
  const ReadOptions base(R"({"broker": {"host": "b", "user": "u", "password-env": "P"}, "base": "z"})");
  EXPECT_TRUE(same_line(one.options, same.options));
  EXPECT_FALSE(same_line(one.options, other.options));
  EXPECT_FALSE(same_line(one.options, secure.options));
  EXPECT_FALSE(same_line(one.options, base.options));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
