#include "networks/zigbee/exposes/mapping.h"

#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

/// `sensor.temperature-1 read`, with what the point has besides its type.
std::string text_of(const MappedPoint& point) {
  const auto& capability = point.capability;
  auto text = fmt::format("{}.{}", model::to_string(capability.point.kind), capability.type_name);
  if (!capability.point.instance.empty()) text += "-" + capability.point.instance;
  text += fmt::format(" {}", model::to_string(capability.access));
  if (!capability.unit.empty()) text += " " + capability.unit;
  if (capability.minimum || capability.maximum) {
    const auto bound = [](const std::optional<double>& one) { return one ? fmt::format("{}", *one) : std::string(); };
    text += fmt::format(" {}..{}", bound(capability.minimum), bound(capability.maximum));
  }
  for (const auto& word : capability.words) text += fmt::format("{}{}", word.value == 0 ? " " : "|", word.text);
  if (capability.data) text += fmt::format(" open:{}", model::to_string(*capability.data));
  if (point.event) text += " uncached";
  if (capability.report == model::Report::kEvent) text += " event";
  if (!capability.reports) text += " silent";
  if (capability.sampled) text += " sampled";
  return text;
}

std::string mapped(const std::string& exposes) {
  const auto definition = map_definition(exposes);
  std::string text;
  for (const auto& point : definition.points) {
    if (point.property == "linkquality") continue;
    text += (text.empty() ? "" : " ; ") + text_of(point);
  }
  for (const auto& one : definition.skipped) text += (text.empty() ? "" : " ; ") + ("skipped " + one);
  return text;
}

TEST(Mapping, FollowsTheCases) {
  const auto cases = rows_of_cases("mapping.tsv");
  ASSERT_GT(cases.size(), 30U);
  for (const auto& row : cases) {
    ASSERT_EQ(row.size(), 2U);
    EXPECT_EQ(mapped(row[0]), row[1]) << row[0];
  }
}

/// A name whose open type has the number of the other's.
std::string twin_of(const std::string& name) {
  for (int i = 0;; ++i) {
    auto twin = fmt::format("twin_{}", i);
    if (model::open_type(twin) == model::open_type(name)) return twin;
  }
}

TEST(Mapping, TwoOpenTypesOfADeviceHaveTwoNumbers) {
  const auto twin = twin_of("brew_strength");
  const auto leaf = [](const std::string& name) {
    return fmt::format(R"({{"type":"numeric","name":"{}","property":"{}","access":7}})", name, name);
  };
  const auto points = map_definition("[" + leaf("brew_strength") + "," + leaf(twin) + "]").points;
  const auto first = points[0].capability.point.type, second = points[1].capability.point.type;
  EXPECT_EQ(first, model::open_type("brew_strength"));
  EXPECT_EQ(static_cast<unsigned>(second), static_cast<unsigned>(first) + 1) << "the next one";
  EXPECT_EQ(points[1].capability.type_name, twin);
}

TEST(Mapping, GroupsHaveNoLinkQuality) {
  std::vector<std::string> skipped;
  const auto leaves = read_exposes("[]", skipped);
  ASSERT_TRUE(leaves);
  EXPECT_TRUE(map_leaves(*leaves, all_types(), false).empty());
  const auto points = map_leaves(*leaves, all_types());
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].capability.type_name, "linkQuality");
  EXPECT_EQ(points[0].property, "linkquality");
}

TEST(Mapping, DevicesThatAreAlikeShareTheirPoints) {
  const auto leaves_of = [](const std::string& property) {
    Leaf leaf;
    leaf.name = leaf.property = property;
    return base::SharedList<Leaf>(std::vector{leaf});
  };
  PointsOfModels models(all_types());
  const auto one = models.of("V\nM", leaves_of("temperature")), other = models.of("V\nM", leaves_of("temperature"));
  EXPECT_EQ(one.begin(), other.begin());
  EXPECT_EQ(one.items(), map_leaves(leaves_of("temperature"), all_types()));
  EXPECT_EQ(models.of("V\nM", leaves_of("humidity"))[0].property, "humidity") << "another definition of this model";
  EXPECT_EQ(one[0].property, "temperature");
}

TEST(Mapping, TheWorkForEqualLeavesIsLinear) {
  constexpr std::size_t kPoints = 512;
  Leaf leaf;
  leaf.name = leaf.property = "a";
  PointNames names;
  Capability capability;
  capability.type_name = "a";
  for (std::size_t i = 0; i < kPoints; ++i) names.name(leaf, "", capability);
  EXPECT_EQ(capability.point.instance, "1-a-511");
  EXPECT_LE(names.tries(), 4 * kPoints);
}

/// The properties of an endpoint belong to its best actuator or sensor, wherever that stands among the leaves.
TEST(Mapping, PropertiesOfAnEndpointBelongToItsActuator) {
  const std::string config =
      R"({"type":"numeric","name":"x","property":"x_ENDPOINT","endpoint":"ENDPOINT","access":7,"category":"config"})";
  const auto setting = [&](const std::string& endpoint) {
    auto json = config;
    for (auto at = json.find("ENDPOINT"); at != json.npos; at = json.find("ENDPOINT")) json.replace(at, 8, endpoint);
    return json;
  };
  const std::string sensor =
      R"({"type":"numeric","name":"power","property":"power_left","endpoint":"left","access":1,"unit":"W"})";
  const std::string actuator =
      R"({"type":"switch","endpoint":"left","features":[{"type":"binary","name":"state","property":"state_left",)"
      R"("endpoint":"left","access":7,"value_on":"ON","value_off":"OFF"}]})";
  const auto points =
      map_definition("[" + setting("left") + "," + setting("right") + "," + sensor + "," + actuator + "]").points;
  EXPECT_EQ(points[0].capability.point.instance, "switch-left");
  EXPECT_EQ(points[1].capability.point.instance, "right");
}

TEST(Mapping, NoPointIsEverStale) {
  for (const auto& point : map_definition(R"([{"type":"text","name":"a","property":"a","access":1}])").points)
    EXPECT_EQ(point.capability.deadline, Duration::zero());
}

TEST(Mapping, LongNamesFitIntoKeysAndMessages) {
  const std::string name(400, 'n');
  const auto points =
      map_definition(
          "[" + fmt::format(R"({{"type":"text","name":"{0}","property":"{0}","endpoint":"{0}","access":7}})", name) +
          "," + fmt::format(R"({{"type":"text","name":"{0}x","property":"{0}x","endpoint":"{0}","access":7}})", name) +
          "]")
          .points;
  EXPECT_EQ(points[0].capability.type_name.size(), 200U);
  EXPECT_EQ(points[0].capability.point.instance.size(), 40U);
  EXPECT_NE(points[0].capability.point, points[1].capability.point);
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
