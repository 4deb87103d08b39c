#include <fmt/format.h>
#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <map>

#include "ecology/report.h"
#include "ecology/roles.h"
#include "support/private_network.h"
#include "tuples/dds/dds_options.h"

namespace {

using namespace rubicon::bench;

const std::map<std::string, void (*)(const Plan&, Report&)> kMeasurements{
    {"latency", measure_latency}, {"throughput", measure_throughput}, {"remote-sets", measure_remote_sets},
    {"joins", measure_joins},     {"memory", measure_memory},         {"crowd", measure_crowd},
    {"churn", measure_churn}};

const std::map<std::string, Role> kRoles{
    {"ping", ping},           {"pong", pong},   {"writer", writer},           {"sink", sink},
    {"commander", commander}, {"desk", desk},   {"island", island},           {"joiner", joiner},
    {"holder", holder},       {"taker", taker}, {"one-of-many", one_of_many}, {"keeper", keeper},
    {"visitors", visitors}};

struct Options {
  std::uint32_t domain = 199;
  std::vector<std::string> only;
  bool quick = false, json = false;
  std::string role, tag, role_options = "{}";
};

void describe(CLI::App& app, Options& options) {
  std::vector<std::string> names;
  for (const auto& [name, measure] : kMeasurements) names.push_back(name);
  app.add_option("--domain", options.domain, "DDS domain, 0 to 230")
      ->check(CLI::Range(0U, rubicon::tuples::dds::kMaxDomain))
      ->capture_default_str();
  app.add_option("--only", options.only, "only this measurement (may be repeated)")
      ->check(CLI::IsMember(names))
      ->allow_extra_args(false);
  app.add_flag("--quick", options.quick, "small sizes: tests the program, measures nothing");
  app.add_flag("--json", options.json, "no progress on standard error");
  app.add_option("--role", options.role)->group("");
  app.add_option("--tag", options.tag)->group("");
  app.add_option("--options", options.role_options)->group("");
}

int play(const Options& options) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // so that an aborted measurement leaves no process behind
  const auto result = kRoles.at(options.role)({options.domain, options.tag}, Json::parse(options.role_options));
  fmt::print("{}\n", result.dump());
  return 0;
}

/// Enters a private network if permitted: no other traffic, and all ports are free.
bool enter_private_network() {
  if (::geteuid() != 0 && ::unshare(CLONE_NEWUSER) != 0) return false;
  static const rubicon::support::PrivateNetwork alone;
  return alone.entered();
}

int measure(const Options& options) {
  Plan plan;
  plan.domain = options.domain;
  plan.is_quick = options.quick;
  if (options.quick) plan.rounds = 1, plan.seconds = 1;
  Report report;
  report.detail("private_network", enter_private_network());
  for (const auto* name : {"latency", "throughput", "remote-sets", "joins", "memory", "crowd", "churn"}) {
    const auto& only = options.only;
    if (!only.empty() && std::find(only.begin(), only.end(), name) == only.end()) continue;
    if (!options.json) fmt::print(stderr, "measuring {} ...\n", name);
    kMeasurements.at(name)(plan, report);
  }
  fmt::print("{}\n", report.json().dump(2));
  return 0;
}

}  // namespace

int main(int count, char** values) {
  CLI::App app("Measures the tuple space over DDS with several processes on this host. Prints one JSON object.");
  Options options;
  describe(app, options);
  CLI11_PARSE(app, count, values);
  return options.role.empty() ? measure(options) : play(options);
}
