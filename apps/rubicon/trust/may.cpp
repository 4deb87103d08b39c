#include <fmt/format.h>

#include <algorithm>

#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/site/commands.h"
#include "base/config_reader.h"
#include "config/config_file.h"
#include "config/rights_config.h"
#include "config/yaml.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "rights/rights_judge.h"
#include "rubicon/key.hpp"

namespace rubicon::cli::trust {

namespace {

using rubicon::rights::Right;
namespace rules = rubicon::rights;

struct MayOptions {
  std::string name, verb, key;
  std::vector<std::string> roles;
  IslandOption island;
};

/// The rules of a configuration, and the prefix of its keys.
struct Rules {
  std::optional<config::RightsSetup> setup;  ///< nullopt: the rules of an island without
  std::string prefix;

  rules::Rights rights() const { return setup ? rules::Rights(setup->rules) : rules::Rights(); }
};

Result<Rules> rules_of(const ConfigNode& root) {
  base::ConfigErrors errors;
  ConfigReader reader(root, "", errors);
  auto setup = config::read_rights(reader);
  auto prefix = reader.map("island").text("prefix", "proxy");
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return Rules{std::move(setup), std::move(prefix)};
}

Result<Rules> rules_of_file(const std::string& file) {
  const auto root = config::load_config(file, {});
  if (!root) return fail(root.error());
  return rules_of(*root);
}

/// Of the realm of brokers: its islands are its ids.
std::optional<tuples::Member> realm_member(const std::string& name) {
  const auto there = rubicon::trust::site::contents_of(site::folder_to_show(""), now());
  if (!there) return {};
  const auto found =
      std::find_if(there->members.begin(), there->members.end(), [&](const auto& one) { return one.name == name; });
  if (found == there->members.end()) return {};
  tuples::Member member{name, found->roles};
  for (const auto island : found->islands) member.ids.push_back({number(island), number(island)});
  return member;
}

/// The member with its roles and islands as the realm knows it; a name that is not there has none.
tuples::Member member_of(const MayOptions& options) {
  tuples::Member member{options.name, options.roles};
  if (member.is_unproven()) return member;
  if (auto found = realm_member(options.name)) return std::move(*found);
  if (options.name.find(':') == options.name.npos)
    print_error(fmt::format("{}: not a member of the realm in {}; the answer is for a member without roles{}",
                            options.name, site::folder_to_show("").string(),
                            options.roles.empty() ? "" : " other than the given ones"));
  return member;
}

/// kInvalid: no rule can answer that.
Result<Right> right_asked(const MayOptions& options) {
  const auto right = rules::right_of(options.verb);
  if (!right)
    return fail(ErrorCode::kInvalid,
                fmt::format("'{}' is not a right, expected read, demand, set, approve or send", options.verb));
  const bool names_island = *right == Right::kSend && options.key.starts_with(rules::kIsland);
  const auto good = names_island ? rules::check_rule_key(options.key) : model::check_key(options.key);
  if (!good) return fail(good.error());
  return *right;
}

int answer(Output& out, const Settings& settings, const MayOptions& options, Right right, const Rules& asked) {
  const rules::RightsJudge judge(asked.rights(), nullptr, asked.prefix);
  const auto decision = judge.explain(member_of(options), right, options.key);
  if (settings.json) {
    Line line{{"name", options.name}, {"right", options.verb}, {"key", options.key}, {"may", decision.allowed}};
    if (decision.rule) line["rule"] = *decision.rule + 1;
    line["why"] = decision.text;
    out.line(model::dump(line));
  } else {
    out.line(fmt::format("{}: {}", decision.allowed ? "yes" : "no", decision.text));
  }
  return ended(out, decision.allowed ? kGood : kRefused);
}

/// By the configuration that a running island has in force.
int ask_island(const Settings& settings, const MayOptions& options, Right right) {
  const auto session = Session::open(settings, "trust may");
  if (!session) return kFailed;
  auto named = options.island;
  if (const int code = named.find(*session); code != kGood) return code;
  const auto key = model::IslandKey{settings.prefix}.settings();
  const auto island = choose_island(*session, named, key.status(), "configuration");
  if (island.code != kGood) return island.code;
  for (const auto& tuple : session->read({island.id, key.value()})) {
    const auto root = config::parse_yaml(tuple.value, fmt::format("island {}", number(island.id)));
    if (!root) return failed(root.error());
    const auto found = rules_of(*root);
    return found ? answer(session->out(), settings, options, right, *found) : failed(found.error());
  }
  return session->not_found(fmt::format("island {} shows no configuration", number(island.id)),
                            "--config FILE asks its file");
}

int may(const Settings& settings, const MayOptions& options) {
  const auto right = right_asked(options);
  if (!right) return failed(right.error());
  if (settings.config.empty()) return ask_island(settings, options, *right);
  const auto found = rules_of_file(settings.config);
  if (!found) return failed(found.error());
  Output out(1);
  return answer(out, settings, options, *right, *found);
}

}  // namespace

void add_may(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<MayOptions>(
      {"may", "Say whether a member may do something, and which rule of the island decides",
       "  rubicon trust may desk set proxy.hall.door.actuator.lock-1.command\n"
       "  rubicon trust may desk read proxy.hall.door.status --config /etc/rubicon/home.yaml\n"
       "  rubicon trust may panel approve proxy.inbox.hall.command\n"
       "Asks a running island, or the file of --config. Exit code 3: it may not.\n",
       parent},
      may);
  app->add_option("NAME", options->name, "name of the member; lan or peis for all components met by DDS or PEIS")
      ->required();
  app->add_option("RIGHT", options->verb, "read, demand, set, approve or send")->required();
  app->add_option("KEY", options->key, "key of a tuple; for send NETWORK.DEVICE, island:ID or own")->required();
  app->add_option("--role", options->roles, "role of a member that the realm does not know (may be repeated)")
      ->allow_extra_args(false);
  options->island.add_to(app);
}

}  // namespace rubicon::cli::trust
