#include <gtest/gtest.h>

#include "network/network.h"
#include "support/fake_host.h"

namespace rubicon::network {
namespace {

struct NumberOption {
  int number = 0;
};

NumberOption read_number(const NetworkConfig& config) {
  return {static_cast<int>(config.options.integer("number", 7, 0, 9))};
}

Result<NumberOption> number_of(const ConfigNode& node) {
  ConfigErrors errors;
  ConfigReader reader(node, "networks.mine", errors);
  TypeCatalogue types;
  support::FakeHost host;
  return read_options<read_number>({"mine", IslandId{1}, reader, types, {}}, host);
}

TEST(ReadOptions, FailsIfTheReaderReportedAnErrorAndElseReturnsTheOptions) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kMap;
  EXPECT_EQ(number_of(node).value().number, 7);
  ConfigNode number;
  number.kind = ConfigNode::Kind::kScalar;
  number.text = "12";
  node.entries.emplace_back("number", number);
  EXPECT_EQ(number_of(node).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(number_of(node).error().text, "network mine: wrong options");
}

}  // namespace
}  // namespace rubicon::network
