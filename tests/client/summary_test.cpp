#include <gtest/gtest.h>

#include "rubicon/summary.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::client {
namespace {

using namespace std::chrono_literals;

TEST(Summary, ComesBackAsItWasSaid) {
  const Summary said{"home \"west\"",  "pi", "rubicon-proxy 0.1.0", "proxy", WallTime{1763726400s + 250ms},
                     {{"knx-hall", 3}}};
  EXPECT_EQ(*model::summary_from_json(model::to_json(said)), said);
}

TEST(Summary, OfManyNetworksStillFits) {
  Summary said{"home", "pi", "", "proxy", {}, {}};
  for (int i = 0; i < 5000; ++i) said.networks["network-" + std::to_string(i)] = 1;
  EXPECT_LE(model::to_json(said).size(), kMaxSummary);
  EXPECT_EQ(model::summary_from_json(model::to_json(said))->name, "home");
}

TEST(Summary, OfStrangersIsTakenAsFarAsItIsSound) {
  EXPECT_FALSE(model::summary_from_json("[1]"));
  EXPECT_FALSE(model::summary_from_json("{"));
  const auto odd = model::summary_from_json(
      R"({"name": 7, "host": "h", "prefix": "a b", "since": -1e300, "networks": {"x": -1, "y": 2, "z": "3"}})");
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->name, "");
  EXPECT_EQ(odd->host, "h");
  EXPECT_EQ(odd->prefix, "");
  EXPECT_EQ(odd->since, WallTime{});
  EXPECT_EQ(odd->networks, (std::map<std::string, std::uint64_t>{{"y", 2}}));
}

}  // namespace
}  // namespace rubicon::client
