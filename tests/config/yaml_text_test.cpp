#include "config/yaml.h"

#include <gtest/gtest.h>

namespace rubicon::config {
namespace {

constexpr std::size_t kMaxCount = 100'000;

ConfigNode tree_of(std::string_view text) {
  auto tree = parse_yaml(text, "x.yaml");
  EXPECT_TRUE(tree) << tree.error().text;
  return tree ? std::move(*tree) : ConfigNode();
}

constexpr const char* kIsland = R"(
island: {id: 6541, name: "home: of all", prefix: proxy}   # a comment
networks:
  knx-hall:
    type: knx
    devices:
      1.4.6: {id: kitchen, name: "6", sensors: {light-1: window, temperature-1: wall}, actuators: {switch-1: lamp}}
      "a b": {name: "quote \" and \\ and é", words: [on, "off", 1.5, -3, null]}
    source: serial@/dev/ttyUSB0:telosb
    empty: {}
    nothing:
    "@odd": ["*", "", "- x", "a: b", "#c", "line\nbreak"]
)";

TEST(YamlText, ReadsAsTheSameTree) {
  const auto tree = tree_of(kIsland);
  const auto text = yaml_text(tree, kMaxCount);
  EXPECT_EQ(differences(tree, tree_of(text), 9), std::vector<std::string>()) << text;
  EXPECT_EQ(yaml_text(tree_of(text), kMaxCount), text);
}

TEST(YamlText, ShortMapsStandOnOneLine) {
  EXPECT_EQ(yaml_text(tree_of("a:\n  b: 1\n  c: [2, 3]\n"), kMaxCount), "a: {b: 1, c: [2, 3]}\n");
}

TEST(YamlText, SecretsAreMasked) {
  const auto text = yaml_text(tree_of("web: {tls: {certificate: web.pem, key: web.key}, tokens: {file: web.tokens}}\n"
                                      "zigbee: {broker: {user: anna, password: geheim, password-file: p}}\n"
                                      "secrets: [one, two]\n"
                                      "url: mqtt://anna:geheim@host\n"),
                              kMaxCount);
  EXPECT_EQ(text,
            "web: {tls: {certificate: web.pem, key: \"****\"}, tokens: {file: web.tokens}}\n"
            "zigbee: {broker: {user: anna, password: \"****\", password-file: p}}\n"
            "secrets: [\"****\", \"****\"]\n"
            "url: mqtt://anna:****@host\n");
}

TEST(YamlText, IsCutAfterAWholeLine) {
  std::string long_one;
  for (int i = 0; i < 100; ++i) long_one += "key" + std::to_string(i) + ": value\n";
  const auto text = yaml_text(tree_of(long_one), 200);
  EXPECT_LE(text.size(), 200U);
  EXPECT_TRUE(text.starts_with("key0: value\n"));
  EXPECT_TRUE(text.ends_with("value\n# the rest is too long to be shown\n")) << text;
}

}  // namespace
}  // namespace rubicon::config
