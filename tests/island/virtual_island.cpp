#include "island/virtual_island.h"

#include <gtest/gtest.h>

#include <string>

#include "config/yaml.h"
#include "island/network_types.h"

namespace rubicon::island {

VirtualIsland::VirtualIsland(std::string_view rooms, std::string_view more) {
  const auto text =
      "island: {id: 6541, name: home}\nnetworks:\n  dummy-1: {type: dummy, simulate: " + std::string(rooms) + "}\n" +
      std::string(more);
  const auto tree = config::parse_yaml(text, "island.yaml");
  base::ConfigErrors errors;
  auto config = island::read_island_config(tree.value(), island::network_types(), errors);
  auto made = island::Island::make(std::move(config), time, files, log, ecology, errors);
  EXPECT_TRUE(made) << errors.text();
  island = std::move(made.value());
  link = ecology.join(OwnerId(65536)).value();
  space = std::make_unique<TupleSpace>(OwnerId(65536), time, *link);
  island->start();
  time.run_ready();
}

}  // namespace rubicon::island
