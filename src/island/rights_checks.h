#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "island/island_config.h"
#include "rights/audit.h"
#include "rights/rights_judge.h"

namespace rubicon::island {

/// The rules of the configuration; those of an island without `rights:` otherwise.
rights::Rights rights_of(const IslandConfig& config);
/// The judge for the links of the island's process; null: there are neither rights nor a realm.
std::shared_ptr<rights::RightsJudge> make_judge(const IslandConfig& config);
/// Where the audit of that judge goes: beside the state file unless the configuration names a file; without either to
/// the log only.
rights::AuditOptions audit_options(const IslandConfig& config);
/// `trust_lan` beside rights is an error: both would say what components of other hosts may do.
void check_rights(const IslandConfig& config, base::ConfigErrors& errors);
/// What is probably a mistake, each with its place: rules that match nothing, unknown names, a wire without
/// protection. `names`: names and roles of all certificates and tokens of the page; nullopt = not known.
std::vector<std::string> rights_warnings(const IslandConfig& config,
                                         const std::optional<std::vector<std::string>>& names);

}  // namespace rubicon::island
