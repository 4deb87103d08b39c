#include <CLI/CLI.hpp>

#include "runtime/daemon.h"

namespace {

using rubicon::runtime::RunOptions;

void describe_run(CLI::App& app, RunOptions& options) {
  auto* run = app.add_subcommand("run", "Run the island that FILE describes");
  run->add_option("FILE", options.file, "island configuration (YAML)")->required();
  run->add_option("--set", options.overrides, "override a value: networks.NAME.KEY=VALUE (may be repeated)")
      ->allow_extra_args(false);
  run->add_option("--watch", options.watch, "print a JSON line for each set of a matching tuple (active subscription)")
      ->allow_extra_args(false);
  run->add_flag("--shell", options.shell, "read commands from standard input, answer in JSON lines");
  run->add_option("--log-level", options.log_level, "what goes to standard error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The proxy of a Rubicon island: every sensor and actuator of unlike networks as tuples",
               "rubicon-proxy");
  app.set_version_flag("--version", "rubicon-proxy " RUBICON_VERSION);
  app.require_subcommand(1);
  RunOptions options;
  describe_run(app, options);
  auto* check = app.add_subcommand("check", "Say what is wrong with FILE, without running it");
  check->add_option("FILE", options.file, "island configuration (YAML)")->required();
  check->add_option("--set", options.overrides, "override a value before checking")->allow_extra_args(false);
  std::string old_file;
  auto* diff = check->add_option(
      "--diff", old_file, "say what a reload would change: against OLD, or what the daemon was last started with");
  diff->expected(0, 1)->type_name("OLD");
  auto* networks = app.add_subcommand("networks", "List the network types with sample configurations");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // also --help and --version, which end well
    return app.exit(error) == 0 ? rubicon::runtime::kExitOk : rubicon::runtime::kExitFailed;
  }
  if (check->parsed()) {
    const auto against = diff->count() > 0 ? std::optional(old_file) : std::nullopt;
    return rubicon::runtime::check(options.file, options.overrides, against);
  }
  if (networks->parsed()) return rubicon::runtime::list_networks();
  return rubicon::runtime::run(options);
}
