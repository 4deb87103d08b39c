#include "island/overview.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "support/folder.h"
#include "virtual_island.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

/// The overview of a component beside an island, and what a page asks of it.
struct OverviewTuple : testing::Test {
  OverviewTuple() { start(); }
  void start() {
    overview.reset();
    overview.emplace(*at.space, "home", store.get());
    at.time.run_ready();
  }
  tuples::Reply ask(std::string_view text) {
    tuples::Reply got;
    at.island->space().set_remote(at.space->self(), "home.overview", text, 0s,
                                  [&](const tuples::Reply& reply) { got = reply; });
    at.time.run_for(1s);
    return got;
  }
  json shown() { return json::parse(at.space->get(at.space->self(), "home.overview")->value); }

  support::Folder folder;
  VirtualIsland at{"{den: {}}"};
  std::unique_ptr<state::StateStore> store = state::StateStore::open(folder / "s", IslandId{1}).value();
  std::optional<Overview> overview;
};

TEST_F(OverviewTuple, AChangeLeavesTheOtherMembers) {
  EXPECT_EQ(shown(), json::parse(R"({"rooms":[],"pins":[],"names":{}})"));
  EXPECT_EQ(ask(R"({"rooms":["Kitchen","Hall"]})").verdict, Verdict::kApplied);
  EXPECT_EQ(ask(R"({"pins":["wsn-1.7.sensor.light-1"]})").verdict, Verdict::kApplied);
  EXPECT_EQ(ask(R"({"names":{"a.b.sensor.c":"Window","a.b.sensor.d":"Door"}})").verdict, Verdict::kApplied);
  EXPECT_EQ(ask(R"({"names":{"a.b.sensor.c":""}})").verdict, Verdict::kApplied);
  EXPECT_EQ(shown(), json::parse(R"({"rooms":["Kitchen","Hall"],"pins":["wsn-1.7.sensor.light-1"],
                                     "names":{"a.b.sensor.d":"Door"}})"));
}

TEST_F(OverviewTuple, IsKeptOverARestart) {
  ASSERT_EQ(ask(R"({"rooms":["Küche"]})").verdict, Verdict::kApplied);
  start();
  EXPECT_EQ(shown()["rooms"], json::array({"Küche"}));
}

TEST_F(OverviewTuple, RefusesWhatIsNoneAndChangesNothing) {
  ASSERT_EQ(ask(R"({"rooms":["Hall"]})").verdict, Verdict::kApplied);
  const auto long_text = std::string(257, 'a');
  for (const auto& text :
       {std::string(), std::string("{}"), std::string("[]"), std::string(R"({"rooms":"Hall"})"),
        std::string(R"({"rooms":[7]})"), std::string(R"({"pins":[["a"]]})"), std::string(R"({"rooms":["a\nb"]})"),
        std::string(R"({"names":["a"]})"), std::string(R"({"names":{"a":7}})"),
        std::string(R"({"rooms":["Attic"],"colour":"red"})"), R"({"rooms":[")" + long_text + R"("]})"}) {
    const auto reply = ask(text);
    EXPECT_EQ(reply.verdict, Verdict::kRefused) << text;
    EXPECT_EQ(reply.code, ErrorCode::kInvalid) << text;
  }
  json many = json::array();
  for (int i = 0; i < 300; ++i) many.push_back(std::string(250, 'a'));
  EXPECT_EQ(ask(json{{"pins", many}}.dump()).code, ErrorCode::kOutOfRange);
  EXPECT_EQ(shown(), json::parse(R"({"rooms":["Hall"],"pins":[],"names":{}})"));
}

TEST_F(OverviewTuple, WithoutAStateFileEverySetIsRefused) {
  store.reset();
  start();
  const auto reply = ask(R"({"rooms":["Hall"]})");
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_THAT(reply.text, testing::HasSubstr("no state file"));
}

}  // namespace
}  // namespace rubicon::island
