#include <gmock/gmock.h>

#include "runtime/island_config.h"
#include "runtime/network_types.h"
#include "runtime/yaml.h"

namespace rubicon::runtime {
namespace {

IslandConfig read(const std::string& tuples, base::ConfigErrors& errors) {
  const auto tree = parse_yaml("island: {id: 1}\ntuples: " + tuples + "\n", "home.yaml");
  return read_island_config(tree.value(), network_types(), errors);
}

TEST(EngineConfig, IsMemoryUnlessSaidOtherwise) {
  base::ConfigErrors errors;
  EXPECT_FALSE(read("{}", errors).engine.dds);
  const auto dds = read("{engine: dds, domain: 7, tag: lab, lease: 3s}", errors).engine;
  EXPECT_TRUE(errors.empty()) << errors.text();
  EXPECT_TRUE(dds.dds);
  EXPECT_EQ(dds.options.domain, 7U);
  EXPECT_EQ(dds.options.tag, "lab");
  EXPECT_EQ(dds.options.lease, std::chrono::seconds(3));
}

TEST(EngineConfig, SaysWhatIsWrong) {
  for (const auto& [text, part] : {std::pair("{engine: mqtt}", "expected one of: memory, dds"),
                                   std::pair("{engine: dds, domain: 231}", "tuples.domain"),
                                   std::pair("{engine: dds, lease: 100ms}", "expected from 500ms to 60s"),
                                   std::pair("{tag: lab}", "only engine dds has that"),
                                   std::pair("{engine: dds, interfaces: [eth0]}", "interfaces")}) {
    base::ConfigErrors errors;
    read(text, errors);
    EXPECT_THAT(errors.text(), testing::HasSubstr(part)) << text;
  }
}

}  // namespace
}  // namespace rubicon::runtime
