// The section `rights:` of a configuration, and the rules that are made of it: whatever they say, what one rule denies
// no other allows, and the answers of all ways to ask agree.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "config/rights_config.h"
#include "config/yaml.h"
#include "fuzz_target.h"
#include "rights/rights.h"

namespace rubicon::fuzz::rights_fuzz {

namespace {

using rights::Right;
using rights::Rights;

void expect(bool good) {
  if (!good) std::abort();
}

void ask(const Rights& rights, const tuples::Member& who, std::string_view key) {
  const auto access = rights.access(who, key);
  const auto read = rights.decide(who, Right::kRead, key), demand = rights.decide(who, Right::kDemand, key);
  expect(read.allowed == access.read && demand.allowed == access.demand);
  expect(!read.allowed || read.rule.has_value());
  if (rights.sees_all(who)) expect(access.read && access.demand && access.interval == Duration(0));
  for (const auto right : rights::kRights) expect(!rights.decide(who, right, key).text.empty());
}

}  // namespace

FUZZ_TARGET(rights) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto root = config::parse_yaml(text, "home.yaml");
  if (!root) return 0;
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  auto setup = config::read_rights(reader);
  if (!setup || !errors.empty()) return 0;
  const tuples::Member members[] = {
      {.name = "robot", .roles = {"admin", "kids"}}, {.name = "two", .ids = {{2, 2}}}, {.name = "peis"}};
  const Rights rights(setup->rules);
  auto reversed = setup->rules;
  std::reverse(reversed.begin(), reversed.end());
  const Rights other(std::move(reversed));
  for (const auto& who : members) {
    for (const auto* key : {"proxy", "proxy.wsn-1.7.sensor.motion-1.value", "proxy.a.b.actuator.lock-1.command", "own",
                            "island:2", "wsn-1.7"}) {
      ask(rights, who, key);
      expect(rights.access(who, key) == other.access(who, key));
    }
  }
  return 0;
}

}  // namespace rubicon::fuzz::rights_fuzz
