#include "networks/knx/bench.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/point_table.h"

namespace rubicon::networks::knx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::string_view kScenes = R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
  "1/0/1": {"dpt": "18.001", "scenes": {"1": "evening", "64": "all off"}},
  "1/0/2": {"dpt": "17.001", "kind": "sensor", "scenes": {"2": "cinema"}},
  "1/0/3": "17.001"}})";

class KnxScenes : public KnxBench {
 protected:
  Result<void> command(Value value) {
    auto sent = send(model::Actuate{5, point(Kind::kActuator, "namedScene"), std::move(value)}, "1/0/1");
    host.time.run_for(1s);
    return sent;
  }
};

TEST_F(KnxScenes, AreRecalledAndStoredByNameAndByTheNumberThatEtsShows) {
  start(kScenes);
  const std::pair<Value, std::uint8_t> commands[] = {{Value("evening"), 0x00},
                                                     {Value("all off"), 0x3f},
                                                     {Value("store evening"), 0x80},
                                                     {Value(std::int64_t{5}), 0x04},
                                                     {Value("store 5"), 0x84}};
  for (const auto& [value, byte] : commands) {
    ASSERT_TRUE(command(value)) << model::to_text(value);
    EXPECT_EQ(telegrams("1/0/1", {0x00, 0x80, byte}), 1) << model::to_text(value);
  }
  for (const auto& wrong : {Value(std::int64_t{0}), Value(std::int64_t{65}), Value(std::int64_t{128}),
                            Value(std::int64_t{193}), Value("morning")}) {
    const auto refused = command(wrong);
    ASSERT_FALSE(refused) << model::to_text(wrong);
    EXPECT_THAT(refused.error().text, HasSubstr("a number from 1 to 64, or 'store' and one of both"));
  }
}

TEST_F(KnxScenes, AreShownAsWordsAndElseAsNumbersFromOne) {
  start(kScenes);
  for (const auto byte : Bytes{0x00, 0x80, 0x04, 0x84, 0x3f}) server.inject(0x1105, group("1/0/1"), 0x80, {byte});
  for (const auto byte : Bytes{0x01, 0x02, 0x81}) server.inject(0x1105, group("1/0/2"), 0x80, {byte});
  server.inject(0x1105, group("1/0/3"), 0x80, {0x05});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("evening", "store evening", "5", "store 5", "all off"));
  EXPECT_THAT(values_of("1/0/2"), ElementsAre("cinema", "3", "cinema")) << "17.001 stores nothing";
  EXPECT_THAT(values_of("1/0/3"), ElementsAre("5")) << "without names the number of the wire, as before";
}

TEST_F(KnxScenes, TheDescriptionHasTheWordsAndBoundsOfThePoint) {
  start(kScenes);
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(3));
  const auto& recall = joins[1].second.capabilities.at(0);
  EXPECT_EQ(recall.words, (std::vector<model::Word>{{2, "cinema"}}));
  EXPECT_EQ(recall.minimum, 1);
  EXPECT_EQ(recall.maximum, 64);
  const auto& both = joins[0].second.capabilities.at(0);
  EXPECT_EQ(both.words.at(2), (model::Word{129, "store evening"}));
  EXPECT_EQ(both.words.at(3), (model::Word{130, "store 2"}));
  EXPECT_EQ(both.maximum, 192);
  EXPECT_EQ(joins[2].second.capabilities.at(0).point, point(Kind::kActuator, "scene"));
}

TEST_F(KnxScenes, WrongNamesAreNamedWithTheirPlace) {
  const auto why = [&](const std::string& entry) {
    ConfigErrors found;
    const auto text = R"({"host": "a", "groups": {"1/0/1": )" + entry + "}}";
    const ConfigNode node = support::config_of(std::string_view(text));
    ConfigReader reader(node, "networks.knx", found);
    EXPECT_FALSE(kType.make({"knx", IslandId{1}, reader, types, {}}, host)) << entry;
    return found.text();
  };
  EXPECT_THAT(why(R"({"dpt": "5.001", "scenes": {"1": "a"}})"), HasSubstr("only for the types 17.001 and 18.001"));
  EXPECT_THAT(why(R"({"dpt": "17.001", "scenes": {"0": "a"}})"), HasSubstr("expected 1 to 64"));
  EXPECT_THAT(why(R"({"dpt": "17.001", "scenes": {"1": "7"}})"), HasSubstr("which is not a number"));
  for (const std::string name : {"store it", "Store it"})
    EXPECT_THAT(why(R"({"dpt": "17.001", "scenes": {"1": ")" + name + "\"}}"),
                HasSubstr("does not begin with 'store'"));
  EXPECT_THAT(why(R"({"dpt": "17.001", "scenes": {"1": "all off", "2": "All-Off"}})"), HasSubstr("another scene too"));
}

TEST(KnxSceneFile, NamesAreWrittenAndKeptByAMerge) {
  groups::GroupPoint known;
  known.address = wire::parse_group("1/0/1").value();
  known.dpt = dpt::parse_dpt("18.001").value();
  known.kind = Kind::kActuator;
  known.scenes = groups::SceneNames{{1, "evening"}, {2, "on"}};
  auto imported = known;
  imported.scenes.reset();
  imported.name = "Scenes";
  groups::Report report;
  const auto merged = groups::merge({known}, {imported}, report);
  EXPECT_THAT(groups::to_yaml(merged, "x"), HasSubstr(R"(scenes: {1: evening, 2: "on"}, name: Scenes)"));
}

}  // namespace
}  // namespace rubicon::networks::knx
