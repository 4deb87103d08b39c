#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>

#include "apps/simulators/zigbee/device_model.h"
#include "networks/zigbee/exposes/mapping.h"

namespace rubicon::networks::zigbee {
namespace {

std::set<std::string> point_ids(const zigbee_simulator::DeviceModel& model) {
  const TypeCatalogue types;
  std::vector<std::string> skipped;
  std::set<std::string> ids;
  for (const auto& point :
       exposes::map_leaves(exposes::read_exposes(model.definition["exposes"].dump(), skipped).value(), types)) {
    const auto& capability = point.capability;
    const auto* type = types.find(capability.point.type);
    const std::string name = type ? std::string(type->name) : capability.type_name;
    ids.insert(capability.point.instance.empty() ? name : name + "-" + capability.point.instance);
  }
  return ids;
}

/// docs/zigbee.md shows what becomes of ten models: each point that it names is there.
TEST(ModelsOfThePage, BecomeThePointsThatThePageNames) {
  std::ifstream page(RUBICON_SOURCE_DIR "/docs/zigbee.md");
  ASSERT_TRUE(page);
  static const std::regex kPoint(R"re(`(?:sensor\.|actuator\.|property\.)?([a-z][A-Za-z0-9_]*(?:-[a-z0-9-]+)?)`)re");
  std::size_t rows = 0;
  for (std::string line; std::getline(page, line);) {
    for (const auto& name : zigbee_simulator::model_names()) {
      const auto model = zigbee_simulator::find_model(name).value();
      const auto title = model.definition["model"].get<std::string>();
      const auto shown = title.substr(0, title.find_first_of(" _(", 4));
      if (!line.starts_with("| " + model.definition["vendor"].get<std::string>() + " " + shown)) continue;
      ++rows;
      const auto ids = point_ids(model);
      const auto cell = line.substr(line.find('|', 2));
      std::size_t named = 0;
      for (std::sregex_iterator it(cell.begin(), cell.end(), kPoint), end; it != end; ++it) {
        const auto id = (*it)[1].str();
        if (id == "contact" || id == "position" || id == "toggle" || id.find("brightness_") == 0)
          continue;  // of Zigbee2MQTT
        ++named;
        EXPECT_THAT(ids, testing::Contains(id)) << line;
      }
      EXPECT_GE(named, 2U) << line;
    }
  }
  EXPECT_GE(rows, 10U);
}

}  // namespace
}  // namespace rubicon::networks::zigbee
