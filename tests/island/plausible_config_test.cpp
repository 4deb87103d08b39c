#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/yaml.h"
#include "island/island_config.h"
#include "island/network_types.h"

namespace rubicon::island {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

IslandConfig config_of(std::string_view text, base::ConfigErrors& errors) {
  auto tree = config::parse_yaml(text, "x.yaml");
  EXPECT_TRUE(tree) << tree.error().text;
  return read_island_config(std::move(*tree), network_types(), errors);
}

std::string dummy_network(const std::string& network) {
  return "island: {id: 6541, name: home}\nnetworks:\n  " + network + "\n";
}

TEST(PlausibleConfig, IsReadForTypesAndPoints) {
  base::ConfigErrors errors;
  const auto config = config_of(
      dummy_network(
          "dummy: {type: dummy, valid: {illuminance: {maximum: 5000}},\n"
          "    devices: {1: {valid: {temperature-1: {minimum: -5.5, maximum: 40, step: 3, not: [85, 0]}, energy-1: "
          "{rises: yes, not: []}}}}}"),
      errors);
  EXPECT_THAT(errors.lines(), IsEmpty());
  const auto& rules = config.proxy.networks.at("dummy");
  ASSERT_TRUE(rules.valid.contains("light")) << "a former name";
  EXPECT_EQ(rules.valid.at("light").maximum, 5000);
  const auto& of_device = rules.devices.at("1").valid;
  const auto& temperature = of_device.at("temperature-1");
  EXPECT_EQ(temperature.minimum, -5.5);
  EXPECT_EQ(temperature.maximum, 40);
  EXPECT_EQ(temperature.step, 3);
  EXPECT_FALSE(temperature.rises);
  EXPECT_EQ(temperature.never, (std::vector<double>{85, 0}));
  EXPECT_TRUE(of_device.at("energy-1").rises);
  EXPECT_EQ(of_device.at("energy-1").never, std::vector<double>());
}

TEST(PlausibleConfig, MistakesInWhatIsPlausibleNameTheirPlace) {
  const std::pair<std::string, std::string> mistakes[] = {
      {"valid: {tempreture: {minimum: 3}}", "valid.tempreture: is not a type"},
      {"valid: {temperature: {minimum: 3, maximum: 2}}", "temperature.minimum: is 3, expected at most the maximum 2"},
      {"valid: {temperature: {step: 0}}", "temperature.step: expected more than 0"},
      {"valid: {temperature: {not: [x]}}", "temperature.not: 'x' is not a number"},
      {"valid: {temperature: {min: 3}}", "minimum"},
      {"valid: {lamp: {minimum: 3}}", "lamp is not a number"},
      {"devices: {1: {valid: {temperature: {minimum: 3}}}}", "expected a sensor or actuator id such as light-1"}};
  for (const auto& [text, error] : mistakes) {
    base::ConfigErrors errors;
    config_of(dummy_network("dummy: {type: dummy, " + text + "}"), errors);
    EXPECT_THAT(errors.text(), HasSubstr(error)) << text;
    EXPECT_EQ(errors.lines().size(), 1U) << errors.text();
  }
}

}  // namespace
}  // namespace rubicon::island
