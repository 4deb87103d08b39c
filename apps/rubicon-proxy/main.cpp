#include <CLI/CLI.hpp>

#include "runtime/daemon.h"
#include "runtime/recording_tool.h"

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

CLI::App* describe_recording(CLI::App& app, rubicon::runtime::RecordingOptions& options, bool& csv) {
  auto* recording = app.add_subcommand("recording", "Say what is in a recording, or write it as text");
  recording->add_option("FILE", options.file, "what a recorder wrote")->required();
  recording->add_option("ACTION", options.action, "info or export")
      ->check(CLI::IsMember({"info", "export"}))
      ->required();
  auto* as_csv = recording->add_flag("--csv", csv, "export as a table (the default)");
  recording->add_flag("--jsonl", options.jsonl, "export as JSON lines")->excludes(as_csv);
  recording->add_option("--pattern", options.pattern, "export only what matches, for example proxy.*.*.sensor.**");
  recording->add_option("--out", options.out, "export to this new file instead of standard output");
  return recording;
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
  auto* networks = app.add_subcommand("networks", "List the network types with sample configurations");
  rubicon::runtime::RecordingOptions recording_options;
  bool csv = false;
  auto* recording = describe_recording(app, recording_options, csv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // also --help and --version, which end well
    return app.exit(error) == 0 ? rubicon::runtime::kExitOk : rubicon::runtime::kExitFailed;
  }
  if (check->parsed()) return rubicon::runtime::check(options.file, options.overrides);
  if (recording->parsed()) return rubicon::runtime::recording(recording_options);
  if (networks->parsed()) return rubicon::runtime::list_networks();
  return rubicon::runtime::run(options);
}
