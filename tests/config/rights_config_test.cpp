#include "config/rights_config.h"

#include <gmock/gmock.h>

#include "config/yaml.h"

namespace rubicon::config {
namespace {

using rights::Right;
using rights::RightSet;
using testing::ElementsAre;
using testing::HasSubstr;

std::optional<RightsSetup> read_all(const std::string& yaml, base::ConfigErrors& errors) {
  const auto root = parse_yaml(yaml, "home.yaml");
  EXPECT_TRUE(root);
  if (!root) return std::nullopt;
  ConfigReader reader(*root, "", errors);
  return read_rights(reader);
}

std::string wrong_rule(const std::string& rule) {
  base::ConfigErrors errors;
  std::ignore = read_all("rights:\n  - " + rule + "\n", errors);
  return errors.text();
}

TEST(RightsConfig, WithoutTheSectionThereIsNone) {
  base::ConfigErrors errors;
  EXPECT_FALSE(read_all("a: 1\n", errors));
  EXPECT_TRUE(read_all("rights: []\n", errors));
  EXPECT_TRUE(errors.empty()) << errors.text();
}

TEST(RightsConfig, ReadsAllKeysOfARule) {
  base::ConfigErrors errors;
  const auto setup = read_all(
      "rights:\n"
      "  - {who: admin, may: all}\n"
      "  - {who: [lab, island:2], may: [read, demand], keys: [a.**, b], not: \"a.motion-*\", interval: 10s}\n",
      errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  ASSERT_TRUE(setup && setup->rules.size() == 2);
  EXPECT_EQ(setup->rules[0].may, RightSet::all());
  EXPECT_THAT(setup->rules[0].keys, ElementsAre("**"));
  const auto& lab = setup->rules[1];
  EXPECT_THAT(lab.who, ElementsAre("lab", "island:2"));
  EXPECT_TRUE(lab.may.has(Right::kRead) && lab.may.has(Right::kDemand) && !lab.may.has(Right::kSet));
  EXPECT_THAT(lab.keys, ElementsAre("a.**", "b"));
  EXPECT_THAT(lab.except, ElementsAre("a.motion-*"));
  EXPECT_EQ(lab.interval, std::chrono::seconds(10));
  EXPECT_EQ(lab.place, "home.yaml:3:5");
}

TEST(RightsConfig, ReadsWhoMayVouchForWhom) {
  base::ConfigErrors errors;
  const auto setup =
      read_all("rights:\n  - {who: \"member:hall\", may: vouch, names: [\"user:*\", \"token:tablet\"]}\n", errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  ASSERT_TRUE(setup && setup->rules.size() == 1);
  EXPECT_THAT(setup->rules[0].names, ElementsAre("user:*", "token:tablet"));
  EXPECT_TRUE(setup->rules[0].may.empty());
  EXPECT_THAT(setup->rules[0].keys, ElementsAre());
  EXPECT_THAT(wrong_rule("{who: a, may: vouch}"),
              HasSubstr("rights[0].names: is missing, expected the names it vouches"));
  EXPECT_THAT(wrong_rule("{who: a, may: vouch, names: [a b]}"), HasSubstr("rights[0].names: 'a b': expected names"));
  EXPECT_THAT(wrong_rule("{who: a, may: vouch, names: [\"*\"], keys: [b]}"), HasSubstr("unknown key 'keys'"));
  EXPECT_THAT(wrong_rule("{who: a, may: [vouch, set], keys: [b]}"), HasSubstr("or vouch alone"));
}

TEST(RightsConfig, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(wrong_rule("{who: a, may: write, keys: [b]}"),
            "home.yaml:2:19: rights[0].may: is 'write', expected some of: read, demand, set, approve, send; or all; or "
            "vouch alone");
  EXPECT_THAT(wrong_rule("{who: a, keys: [b]}"), HasSubstr("rights[0].may: is missing, expected some of: read"));
  EXPECT_THAT(wrong_rule("{may: read, keys: [b]}"), HasSubstr("rights[0].who: is missing, expected names or roles"));
  EXPECT_THAT(wrong_rule("{who: [], may: read, keys: [b]}"), HasSubstr("rights[0].who: is missing"));
  EXPECT_THAT(wrong_rule("{who: a b, may: read, keys: [b]}"),
              HasSubstr("home.yaml:2:11: rights[0].who: 'a b': expected"));
  EXPECT_THAT(wrong_rule("{who: a, may: read}"), HasSubstr("rights[0].keys: is missing, expected patterns of keys"));
  EXPECT_THAT(wrong_rule("{who: a, may: read, keys: []}"), HasSubstr("rights[0].keys: is empty, expected patterns"));
  EXPECT_THAT(wrong_rule("{who: a, may: read, keys: [1:b]}"), HasSubstr("rights[0].keys: '1:b': expected parts of"));
  EXPECT_THAT(wrong_rule("{who: a, may: all, not: [a..b]}"), HasSubstr("rights[0].not: 'a..b': expected parts of"));
  EXPECT_THAT(wrong_rule("{who: a, may: read, keys: [b], interval: 5s}"),
              HasSubstr("rights[0].interval: limits demand, expected a rule with the right to demand"));
  EXPECT_THAT(wrong_rule("{who: a, may: demand, keys: [b], interval: 0s}"), HasSubstr("expected more than 0s"));
  EXPECT_THAT(wrong_rule("{who: a, may: read, keys: [b], deny: [c]}"), HasSubstr("deny"));
  EXPECT_THAT(wrong_rule("all"), HasSubstr("rights[0]"));
  base::ConfigErrors errors;
  std::ignore = read_all("rights: {who: a}\n", errors);
  EXPECT_THAT(errors.text(), HasSubstr("rights: is a map, expected a list"));
}

}  // namespace
}  // namespace rubicon::config
