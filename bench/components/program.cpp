#include "components/program.h"

#include <fmt/format.h>
#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>

#include "components/roles.h"
#include "frame/program.h"
#include "support/private_network.h"

namespace rubicon::bench {

namespace {

struct Options {
  std::uint32_t domain = 199;
  std::vector<std::string> only, engines;
  bool quick = false, json = false;
  std::string role, tag, trust_folder, engine, role_options = "{}";
};

std::vector<std::string> names_of(const ComponentProgram& program) {
  std::vector<std::string> names;
  for (const auto& [name, measure] : program.measurements) names.push_back(name);
  return names;
}

void describe(CLI::App& app, const ComponentProgram& program, Options& options) {
  app.add_option("--domain", options.domain, fmt::format("DDS domain, 0 to {}", program.highest_domain))
      ->check(CLI::Range(0U, std::max(program.highest_domain, options.domain)))
      ->capture_default_str()
      ->group(program.highest_domain > 0 ? "Options" : "");
  app.add_option("--only", options.only, "only this measurement (may be repeated)")
      ->check(CLI::IsMember(names_of(program)))
      ->allow_extra_args(false);
  app.add_option("--engine", options.engines, "measure this engine; several alternate, and each has its figures")
      ->check(CLI::IsMember(program.engines))
      ->allow_extra_args(false)
      ->group(program.engines.empty() ? "" : "Options");
  if (program.add_options) program.add_options(app);
  app.add_flag("--quick", options.quick, "small sizes: tests the program, measures nothing");
  app.add_flag("--json", options.json, "no progress on standard error");
  app.add_option("--role", options.role)->group("");
  app.add_option("--tag", options.tag)->group("");
  app.add_option("--trust-folder", options.trust_folder)->group("");
  app.add_option("--of-engine", options.engine)->group("");
  app.add_option("--options", options.role_options)->group("");
}

Role role_of(const ComponentProgram& program, const std::string& name) {
  static const std::map<std::string, Role> kShared{{"ping", ping},
                                                   {"pong", pong},
                                                   {"writer", writer},
                                                   {"sink", sink},
                                                   {"commander", commander},
                                                   {"desk", desk},
                                                   {"island", island},
                                                   {"joiner", joiner},
                                                   {"one-of-many", one_of_many},
                                                   {"paced-writer", paced_writer},
                                                   {"follower", follower},
                                                   {"watched", watched},
                                                   {"watcher", watcher}};
  const auto own = program.roles.find(name);
  return own != program.roles.end() ? own->second : kShared.at(name);
}

int play(const ComponentProgram& program, const Options& options) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // so that an aborted measurement leaves no process behind
  const auto role = role_of(program, options.role);
  fmt::print("{}\n", role({options.domain, options.tag, options.engine, options.trust_folder},
                          Json::parse(options.role_options))
                         .dump());
  return 0;
}

/// Enters a private network if permitted: no other traffic, and all ports are free.
bool enter_private_network() {
  if (::geteuid() != 0 && ::unshare(CLONE_NEWUSER) != 0) return false;
  static const rubicon::support::PrivateNetwork alone;
  return alone.entered();
}

int measure(const ComponentProgram& program, const Options& options) {
  Plan plan;
  plan.domain = options.domain;
  plan.is_quick = options.quick;
  if (options.quick) plan.rounds = 1, plan.seconds = 1;
  plan.is_private = enter_private_network();
  auto engines = options.engines;
  if (engines.empty()) engines = {program.engines.empty() ? "" : program.engines.front()};
  std::map<std::string, Report> reports;
  for (const auto& [name, measure] : program.measurements) {
    const auto& only = options.only;
    if (!only.empty() && std::find(only.begin(), only.end(), name) == only.end()) continue;
    for (const auto& engine : engines) {
      if (!options.json) fmt::print(stderr, "measuring {} {}...\n", name, engine.empty() ? "" : "on " + engine + " ");
      plan.engine = engine;
      measure(plan, reports[engine]);
    }
  }
  Json all = Json::object();
  for (auto& [engine, report] : reports) {
    report.detail("private_network", plan.is_private);
    all[engine] = report.json();
  }
  fmt::print("{}\n", (engines.size() == 1 && !all.empty() ? all.front() : all).dump(2));
  return 0;
}

}  // namespace

int run_components(int count, char** values, const ComponentProgram& program) {
  open_engine = program.open_engine;
  awaits_by_name = program.awaits_by_name;
  CLI::App app(program.purpose, std::filesystem::path(values[0]).filename().string());
  Options options;
  describe(app, program, options);
  CLI11_PARSE(app, count, values);
  if (options.role.empty() && !options.quick && refuses_to_measure(app.get_name().c_str())) return 2;
  return options.role.empty() ? measure(program, options) : play(program, options);
}

}  // namespace rubicon::bench
