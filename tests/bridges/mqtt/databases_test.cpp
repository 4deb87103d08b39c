#include <fstream>
#include <iterator>

#include "bridges/mqtt/real_town.h"
#include "bridges/mqtt/telegraf.h"
#include "config/yaml.h"

namespace rubicon::bridges::mqtt {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

std::string example(const std::string& name) {
  std::ifstream file(std::string(RUBICON_SOURCE_DIR) + "/examples/" + name);
  EXPECT_TRUE(file) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The bridge and the configuration of Telegraf as the examples have them, over a real broker.
TEST_F(RealTown, TelegrafReadsTheObjectsForDatabases) {
  const Telegraf telegraf(example("telegraf.conf"));
  const auto tree = config::parse_yaml(example("mqtt.yaml"), "mqtt.yaml");
  ASSERT_TRUE(tree);
  base::ConfigErrors errors;
  ConfigReader reader(*tree, "", errors);
  auto all = reader.map("bridges");
  auto db = all.map("db");
  island(6545, "on");
  point(6545, "sensor.temperature-1",
        R"({"type":"temperature","data_type":"real","unit":"Cel","access":"read","report":"state"})", "21.5");
  point(6545, "sensor.label-1", R"({"type":"label","data_type":"text","unit":"1","access":"read","report":"state"})",
        "a text");
  bridge(70001, 6545, db);
  Spy spy(world);
  const std::string temperature = "rubicon-db/6545/knx/1/sensor/temperature-1";
  const auto shown = [&](const char* text) {
    const auto payloads = spy.payloads(temperature);
    return std::any_of(payloads.begin(), payloads.end(),
                       [text](const auto& one) { return one.find(text) != one.npos; });
  };
  ASSERT_TRUE(world.until([&] { return shown("21.5"); }));
  put(6545, "proxy.knx.1.sensor.temperature-1.status", R"({"quality":"stale"})");
  ASSERT_TRUE(world.until([&] { return shown("stale"); }));
  std::map<std::string, std::vector<double>> values;
  for (const auto& [topic, payload] : spy.seen) {
    const bool wanted = topic.starts_with("rubicon-db/6545/knx/1/") && !topic.ends_with("/online");
    const auto metric = wanted ? telegraf.take(topic, payload) : std::nullopt;
    if (!metric) continue;
    EXPECT_EQ(metric->name, "rubicon");
    EXPECT_GT(metric->time, 1'600'000'000);
    EXPECT_EQ(metric->tags.at("island"), "6545");
    EXPECT_EQ(metric->tags.at("device"), "1");
    EXPECT_EQ(metric->tags.contains("unit"), metric->tags.at("point") == "temperature-1");
    EXPECT_THAT(metric->fields, ElementsAre(Pair("value", ::testing::_)));
    values[metric->tags.at("kind") + " " + metric->tags.at("point")].push_back(metric->fields.at("value"));
  }
  EXPECT_THAT(values,
              ElementsAre(Pair("actuator lamp-1", ElementsAre(1)), Pair("sensor temperature-1", ElementsAre(21.5))))
      << "a text, and what is not of now, are no numbers";
  EXPECT_THAT(telegraf.topics(), ElementsAre("rubicon-db/+/+/+/+/+"));
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
