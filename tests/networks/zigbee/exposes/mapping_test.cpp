#include "networks/zigbee/exposes/mapping.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "networks/zigbee/exposes/type_table.h"

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
  static const TypeCatalogue types;
  std::vector<std::string> skipped;
  const auto leaves = read_exposes(exposes, skipped);
  if (!leaves) return leaves.error().text;
  std::string text;
  for (const auto& point : map_leaves(*leaves, types)) {
    if (point.property == "linkquality") continue;
    text += (text.empty() ? "" : " ; ") + text_of(point);
  }
  for (const auto& one : skipped) text += (text.empty() ? "" : " ; ") + ("skipped " + one);
  return text;
}

std::vector<std::pair<std::string, std::string>> cases_of(const char* name) {
  std::ifstream file(std::string(RUBICON_SOURCE_DIR "/tests/cases/zigbee/") + name);
  std::vector<std::pair<std::string, std::string>> cases;
  for (std::string line; std::getline(file, line);) {
    const auto tab = line.find('\t');
    if (line.starts_with('#') || tab == line.npos) continue;
    cases.emplace_back(line.substr(0, tab), line.substr(tab + 1));
  }
  return cases;
}

TEST(Mapping, FollowsTheCases) {
  const auto cases = cases_of("mapping.tsv");
  ASSERT_GT(cases.size(), 10U);
  for (const auto& [exposes, points] : cases) EXPECT_EQ(mapped(exposes), points) << exposes;
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
