#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "rights/rights_judge.h"

namespace rubicon::support {

using rights::Right;

/// Keeps the lines of an audit: `robot set proxy.a: accepted`.
class CollectingAudit final : public rights::Audit {
 public:
  void write(const rights::AuditLine& line) override {
    lines.push_back(line.who.name + " " + std::string(line.verb) + " " + std::string(line.key) + ": " +
                    (line.accepted ? "accepted" : "refused"));
    hosts.emplace_back(line.host);
    values.emplace_back(line.value);
    throughs.push_back(line.who.through);
    whys.emplace_back(line.why);
    quotes.push_back(line.quotes);
  }
  std::vector<std::string> lines, values, hosts, throughs, whys;
  std::vector<bool> quotes;
};

inline rights::Rule rule(std::string who, std::initializer_list<Right> may, std::vector<std::string> keys = {"**"},
                         std::vector<std::string> except = {}) {
  rights::Rule made;
  made.who = {std::move(who)};
  for (const auto right : may) made.may.add(right);
  made.keys = std::move(keys);
  made.except = std::move(except);
  return made;
}

inline std::shared_ptr<rights::RightsJudge> judge_of(std::vector<rights::Rule> rules,
                                                     std::shared_ptr<rights::Audit> audit) {
  return std::make_shared<rights::RightsJudge>(rights::Rights(std::move(rules)), std::move(audit));
}

/// The member of an island, and one with a block of ids for tools.
inline tuples::Member island_member(std::uint32_t id) {
  return {"island-" + std::to_string(id), {}, {{id, id}}};
}
inline tuples::Member tool_member(std::string name, std::uint32_t id) {
  return {std::move(name), {}, {{id, id + 99}}};
}

}  // namespace rubicon::support
