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

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
