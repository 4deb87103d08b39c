#include "apps/rubicon/cli.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <sstream>

#include "apps/program/process.h"
#include "apps/program/usage_error.h"
#include "apps/rubicon/program.h"
#include "trust/secret_text.h"

namespace rubicon::cli {

namespace {

constexpr const char* kAbout =
    "Reads, watches and commands the sensors and actuators of RUBICON islands, each of them a tuple.\n"
    "Finds the islands of this host without configuration.\n\n"
    "A TUPLE is a key (proxy.dummy-rooms.living.sensor.light-1.value), with its owner in front where several\n"
    "islands have it (6541:proxy...), or short: living.light-1, dummy-rooms.living.light-1, 'Living room.light'.\n"
    "A PATTERN is a key in which * stands for one part and a last ** for the rest.";

constexpr const char* kExamples =
    "Examples:\n"
    "  rubicon islands\n"
    "  rubicon ls 'proxy.*.*.sensor.*.value'\n"
    "  rubicon watch living.light-1\n"
    "  rubicon set living.lamp-1 on\n"
    "  rubicon doctor\n"
    "`rubicon COMMAND --help` has more.\n\n";

/// Commands that take the terminal, or go on until a signal.
constexpr std::array<std::string_view, 5> kEndless{"top", "watch", "record", "log", "send"};

/// Commands of `rubicon trust`.
bool may_read_key(const CLI::App& command) {
  for (const auto* above = command.get_parent(); above != nullptr; above = above->get_parent()) {
    if (above->get_name() == "trust") return true;
  }
  return false;
}

/// The command of the line, not one above its subcommand.
bool is_meant(const CLI::App& command) {
  return command.parsed() && command.get_subcommands().empty();
}

}  // namespace

Cli::Cli() : app_(kAbout, "rubicon") {
  app_.set_version_flag("--version", [] { return program::version_text("rubicon"); });
  app_.require_subcommand(1);
  app_.fallthrough();
  app_.get_formatter()->label("SUBCOMMAND", "COMMAND");
  app_.footer(std::string(kExamples) + kExitCodes);
  settings_.add_to(app_);
  for (const auto add : {add_islands,  add_networks, add_ls,     add_tree,    add_get,      add_set,    add_watch,
                         add_devices,  add_describe, add_rename, add_inbox,   add_alerts,   add_send,   add_receive,
                         add_publish,  add_types,    add_record, add_history, add_recorder, add_replay, add_log,
                         add_settings, add_top,      add_doctor, add_knx,     add_zigbee,   add_trust,  add_wsn,
                         add_web,      add_mqtt,     add_ros2,   add_token,   add_complete, add_manual}) {
    add(*this);
  }
}

CLI::App* Cli::command(const Text& text, Run run) {
  auto* app = (text.under ? text.under : &app_)->add_subcommand(text.name, text.summary);
  app->footer("Examples:\n" + text.examples +
              "Options of all commands (--domain, --interfaces, --json, ...): `rubicon --help`.");
  commands_.push_back({app, std::move(run)});
  return app;
}

CLI::App* Cli::command_in_ecology(const Text& text, SessionRun run) {
  auto* app = command(text, [name = text.name, run](const Settings& settings) {
    const auto session = Session::open(settings, name);
    return session ? session->end(run(*session)) : static_cast<int>(kFailed);
  });
  commands_.back().in_session = std::move(run);
  return app;
}

CLI::Option* add_duration_option(CLI::App* app, const std::string& name, std::string& text, const std::string& about) {
  return app->add_option(name, text, about)->type_name("SPAN")->check(check_duration);
}

int Cli::run(int argc, const char* const* argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is not an error
  try {
    app_.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // also --help and --version, which end well
    if (error.get_exit_code() == 0) return app_.exit(error);
    print_error(program::explain(app_, error));
    return kUsage;
  }
  return dispatch();
}

int Cli::dispatch() {
  const auto settings = settings_.read();
  if (!settings) {
    print_error(settings.error().text);
    return kUsage;
  }
  for (const auto& one : commands_) {
    if (!is_meant(*one.app)) continue;
    if (may_read_key(*one.app)) rubicon::trust::keep_memory_private();
    return one.run(*settings);
  }
  return kUsage;
}

int Cli::run_line(Session& session, const std::string& line) {
  try {
    app_.parse(line, false);
  } catch (const CLI::ParseError& error) {  // also --help and --version
    if (error.get_exit_code() != 0) {
      print_error(program::explain(app_, error));
      return kUsage;
    }
    std::ostringstream text;
    std::ignore = app_.exit(error, text, text);
    session.out().write(text.str());
    return kGood;
  }
  if (const auto& typed = app_.parse_order(); !typed.empty()) {
    print_error(typed.front()->get_name() + " belongs to the command line of the program");
    return kUsage;
  }
  for (const auto& one : commands_) {
    if (!is_meant(*one.app)) continue;
    const bool is_endless = std::count(kEndless.begin(), kEndless.end(), one.app->get_name()) > 0;
    if (one.in_session && !is_endless) return one.in_session(session);
  }
  print_error("this command needs a terminal of its own");
  return kUsage;
}

int run_program(int argc, char** argv) {
  Cli cli;
  return cli.run(argc, argv);
}

}  // namespace rubicon::cli
