#include "tuples/dds/trust/member/judged.h"

#include <iostream>

#include "config/config_file.h"
#include "config/rights_config.h"
#include "tuples/space_rights.h"

namespace rubicon::tuples::dds {

namespace {

OwnerId owner_in(const std::string& word) {
  return OwnerId(static_cast<std::uint32_t>(std::stoul(word)));
}

}  // namespace

std::shared_ptr<trust::rights::RightsJudge> Judged::open_judge() {
  using namespace trust::rights;
  return std::make_shared<RightsJudge>(Rights({{.who = {"everybody"}, .may = RightSet::all()}}));
}

Judged::Judged(TupleSpace& space, std::shared_ptr<trust::rights::RightsJudge> judge)
    : space_(space), judge_(std::move(judge)) {}

void Judged::take_rules(const std::string& file) {
  const auto root = config::load_config(file, {});
  base::ConfigErrors errors;
  std::optional<config::RightsSetup> setup;
  if (root) {
    ConfigReader reader(*root, "", errors);
    setup = config::read_rights(reader);
  }
  if (setup) {
    judge_->replace(trust::rights::Rights(setup->rules));
    SpaceRights::rejudge(space_);
  }
  std::cout << "rules " << (setup ? setup->rules.size() : 0) << std::endl;
}

void Judged::obey(const std::vector<std::string>& words) {
  const auto& verb = words.at(0);
  if (verb == "rules") take_rules(words.at(1));
  if (verb == "owns") {
    const auto key = *Pattern::parse(words.at(1));
    std::ignore = space_.set(key.key, "1");
    handles_.push_back(space_.add_policy(key, [](const RemoteSet&) { return SetDecision::applied(); }));
    handles_.push_back(
        space_.watch_demand(key, [this](const Demand& demand) { wanted_[std::string(demand.key)] = demand.wanted; }));
  }
  if (verb == "wanted") std::cout << "wanted " << (wanted_[words.at(1)] ? "yes" : "no") << std::endl;
  if (verb == "sees") handles_.push_back(space_.subscribe(*Pattern::parse(words.at(1)), {}, [](const Event&) {}));
  if (verb == "has")
    std::cout << "has " << (space_.get(owner_in(words.at(1)), words.at(2)) ? "yes" : "no") << std::endl;
  if (verb == "try") {
    space_.set_remote(owner_in(words.at(1)), words.at(2), "2", std::chrono::seconds(30), [](const Reply& reply) {
      std::cout << "try " << (reply.verdict == Verdict::kApplied ? "yes" : "no") << std::endl;
    });
  }
}

}  // namespace rubicon::tuples::dds
