#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/rubicon/session.h"

namespace rubicon::cli {

/// The command line of the program and the commands behind it.
class Cli {
 public:
  using Run = std::function<int(const Settings&)>;
  using SessionRun = std::function<int(Session&)>;

  Cli();
  /// Returns the exit code.
  int run(int argc, const char* const* argv);

  struct Text {
    std::string name, summary, examples;  ///< a line of `examples` is indented
    CLI::App* under = nullptr;            ///< a command that has this one as its own subcommand
  };
  /// Adds a subcommand; `run` is called if the command line names it.
  CLI::App* command(const Text& text, Run run);
  /// The same with options of its own, which live as long as this object.
  template <class Options>
  std::pair<CLI::App*, Options*> command_with(const Text& text, int (*run)(const Settings&, const Options&)) {
    const auto options = std::make_shared<Options>();
    return {command(text, [options, run](const Settings& settings) { return run(settings, *options); }), options.get()};
  }
  /// The same for a command that needs a client.
  CLI::App* command_in_ecology(const Text& text, SessionRun run);

  /// Runs a line of words, as a shell splits them, in a session that is open. Only commands that end by themselves, and
  /// none of the options of all commands. What it prints goes to the output of the session.
  int run_line(Session& session, const std::string& line);

  CLI::App& app() { return app_; }

 private:
  struct Command {
    CLI::App* app;
    Run run;
    SessionRun in_session{};  ///< empty: it opens none, or another one
  };

  int dispatch();

  CLI::App app_;
  SettingsOptions settings_;
  std::vector<Command> commands_;
};

/// Adds an option whose value is a duration (`250ms`, `5s`).
CLI::Option* add_duration_option(CLI::App* app, const std::string& name, std::string& text, const std::string& about);

// Each adds one command, or a few that belong together.
void add_islands(Cli& cli);
void add_networks(Cli& cli);
void add_ls(Cli& cli);
void add_tree(Cli& cli);
void add_get(Cli& cli);
void add_set(Cli& cli);
void add_watch(Cli& cli);
void add_devices(Cli& cli);
void add_describe(Cli& cli);
void add_rename(Cli& cli);
void add_inbox(Cli& cli);
void add_alerts(Cli& cli);
void add_send(Cli& cli);
void add_receive(Cli& cli);
void add_publish(Cli& cli);
void add_types(Cli& cli);
void add_record(Cli& cli);
void add_recorder(Cli& cli);
void add_replay(Cli& cli);
void add_log(Cli& cli);
void add_settings(Cli& cli);
void add_history(Cli& cli);
void add_top(Cli& cli);
void add_doctor(Cli& cli);
void add_knx(Cli& cli);
void add_zigbee(Cli& cli);
void add_trust(Cli& cli);
void add_wsn(Cli& cli);
void add_web(Cli& cli);
void add_web_enable(Cli& cli, CLI::App* web);
void add_mqtt(Cli& cli);
void add_ros2(Cli& cli);
void add_token(Cli& cli);
void add_complete(Cli& cli);
void add_manual(Cli& cli);

}  // namespace rubicon::cli
