#include "apps/rubicon-proxy/daemon.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/program/process.h"
#include "apps/program/usage_error.h"
#include "apps/rubicon-proxy/check.h"
#include "apps/rubicon-proxy/recording_tool.h"
#include "apps/rubicon-proxy/state_tool.h"

namespace rubicon::daemon {

namespace {

void describe_run(CLI::App& app, RunOptions& options) {
  auto* run = app.add_subcommand("run", "Run the island that FILE describes");
  run->add_option("FILE", options.file, "island configuration (YAML)")->required();
  run->add_option("--set", options.overrides, "override a value: networks.NAME.KEY=VALUE (may be repeated)")
      ->allow_extra_args(false);
  run->add_option("--watch", options.watch, "print a JSON line for each set of a matching tuple (active subscription)")
      ->allow_extra_args(false);
  run->add_option("--tuple", options.tuples,
                  "publish a tuple of the island's own from the start: KEY=VALUE (may be repeated)")
      ->allow_extra_args(false);
  run->add_flag("--shell", options.shell, "read commands from standard input, answer in JSON lines");
  run->add_option("--log-level", options.log_level, "what goes to standard error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
}

/// The subcommand, and its option --diff with the file it was given.
std::pair<CLI::App*, CLI::Option*> describe_check(CLI::App& app, CheckOptions& options, std::string& old_file) {
  auto* check = app.add_subcommand("check", "Say what is wrong with FILE, without running it");
  check->add_option("FILE", options.file, "island configuration (YAML)")->required();
  check->add_option("--set", options.overrides, "override a value before checking")->allow_extra_args(false);
  check->add_flag("--elsewhere", options.elsewhere,
                  "the island runs on another host: do not look for the files, folders and interfaces it names");
  auto* diff = check->add_option(
      "--diff", old_file, "say what a reload would change: against OLD, or what the daemon was last started with");
  diff->expected(0, 1)->type_name("OLD");
  return {check, diff};
}

/// `state FILE ...`: what an island remembers.
struct StateTool {
  CLI::App *state = nullptr, *show = nullptr, *exporting = nullptr, *importing = nullptr, *forget = nullptr;
  std::string file, out, from = "-";
  std::vector<std::string> devices;
  bool force = false;

  int run() const {
    if (show->parsed()) return show_state(file);
    if (exporting->parsed()) return export_state(file, out);
    if (importing->parsed()) return import_state(file, from, force);
    return forget_state(file, devices);
  }
};

void describe_state(CLI::App& app, StateTool& tool) {
  tool.state = app.add_subcommand("state", "Show, export, import or forget what an island remembers in FILE");
  tool.state->add_option("FILE", tool.file, "state file of an island")->required();
  tool.state->require_subcommand(1);
  tool.show = tool.state->add_subcommand("show", "List the devices");
  tool.exporting = tool.state->add_subcommand("export", "Write everything as JSON lines");
  tool.exporting->add_option("--out", tool.out, "file to write instead of standard output");
  tool.importing = tool.state->add_subcommand("import", "Merge an export into FILE: all of it or nothing");
  tool.importing->add_option("EXPORT", tool.from, "what `export` wrote; - = standard input")->capture_default_str();
  tool.importing->add_flag("--force", tool.force, "import the export of another island, too");
  tool.forget = tool.state->add_subcommand("forget", "Forget devices, or what a network itself remembers");
  tool.forget
      ->add_option("DEVICE", tool.devices,
                   "NETWORK/ADDRESS, or NETWORK.ID as in keys; NETWORK: its own values, such as sequence numbers")
      ->required();
}

CLI::App* describe_recording(CLI::App& app, RecordingOptions& options, bool& csv) {
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

int run_program(int argc, char** argv) {
  CLI::App app("The proxy of a Rubicon island: every sensor and actuator of unlike networks as tuples",
               "rubicon-proxy");
  app.set_version_flag("--version", [] { return program::version_text("rubicon-proxy"); });
  app.require_subcommand(1);
  RunOptions options;
  describe_run(app, options);
  CheckOptions checked;
  std::string old_file;
  const auto [check_command, diff] = describe_check(app, checked, old_file);
  StateTool state;
  describe_state(app, state);
  auto* networks = app.add_subcommand("networks", "List the network types with sample configurations");
  RecordingOptions recording_options;
  bool csv = false;
  auto* recording_command = describe_recording(app, recording_options, csv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // also --help and --version, which end well
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "rubicon-proxy: %s\n", program::explain(app, error).c_str());
    return kExitConfiguration;
  }
  if (check_command->parsed()) {
    if (diff->count() > 0) checked.against = old_file;
    return check(checked);
  }
  if (recording_command->parsed()) return recording(recording_options);
  if (networks->parsed()) return list_networks();
  if (state.state->parsed()) return state.run();
  return run(options);
}

}  // namespace rubicon::daemon
