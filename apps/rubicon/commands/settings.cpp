#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "transport/local_transports.h"

namespace rubicon::cli {

namespace {

/// A set has at most 1 MiB.
constexpr std::size_t kMaxGroups = 900'000;

struct IslandSettings {
  IslandOption island;
  std::string action = "show";
  std::string network, what, groups;
  bool try_only = false;
};

int show_settings(Session& session, OwnerId island, const model::PointKey& settings) {
  for (const auto& tuple : session.read({island, settings.value()})) {
    if (session.json())
      session.out().line(model::dump(Line{{"island", number(island)}, {"configuration", tuple.value}}));
    else
      session.out().write(tuple.value);
  }
  return kGood;
}

/// `home.yaml:3:7: what`
std::string fault_text(const nlohmann::json& fault) {
  const auto line = model::count_of(fault, "line");
  const auto text = printable(model::text_of(fault, "text"));
  if (line == 0) return text;
  return fmt::format("{}:{}:{}: {}", printable(model::text_of(fault, "file")), line, model::count_of(fault, "column"),
                     text);
}

/// The changes on standard output, the errors on standard error.
void print_outcome(Session& session, const nlohmann::json& status) {
  const auto changes = model::texts_of(status, "changes");
  for (const auto& line : changes) session.out().line(printable(line));
  if (model::text_of(status, "state") == "ok" && changes.empty()) session.out().line("nothing changes");
  session.out().flush();
  const auto errors = status.find("errors");
  if (errors == status.end() || !errors->is_array()) return;
  for (const auto& fault : *errors) print_error(fault_text(fault));
}

/// Of a network; it has to fit into one command.
Result<std::string> read_groups(const std::string& path) {
  transport::LocalTransports disk;
  auto groups = transport::read_text(disk, path, kMaxGroups);
  if (groups || groups.error().code != ErrorCode::kOutOfRange) return groups;
  return fail(ErrorCode::kOutOfRange,
              groups.error().text + ": put it beside the configuration and name it there, as in `import: hall.yaml`");
}

/// What the command says to the island: a word, or the change of its file as JSON.
Result<std::string> command_text(const IslandSettings& options) {
  const auto& action = options.action;
  const bool adds = action == "add", imports = action == "import";
  if (!adds && !imports) {
    if (!options.network.empty() || !options.groups.empty())
      return fail(ErrorCode::kInvalid, fmt::format("settings {} takes no network", action));
    return options.try_only && action == "undo" ? R"({"do":"undo","try":true})" : action;
  }
  if (options.network.empty() || options.what.empty())
    return fail(ErrorCode::kInvalid, adds ? "expected: settings add NETWORK '{type: knx, host: 192.168.1.10}'"
                                          : "expected: settings import NETWORK GROUP-FILE");
  Line change{{"do", action}, {"network", options.network}};
  if (adds) change["options"] = options.what;
  if (const auto& path = imports ? options.what : options.groups; !path.empty()) {
    auto groups = read_groups(path);
    if (!groups) return fail(groups.error());
    change["groups"] = std::move(*groups);
  }
  if (options.try_only) change["try"] = true;
  return model::dump(change);
}

/// What to insert by hand, if the island did not.
void print_patch(Session& session, const nlohmann::json& status) {
  const auto file = status.find("file");
  if (file == status.end()) return;
  const auto patch = model::text_of(*file, "patch");
  if (!patch.empty()) session.out().write("\n" + patch);
}

int reload_settings(Session& session, OwnerId island, const model::PointKey& settings, const IslandSettings& options) {
  const auto text = command_text(options);
  if (!text) {
    print_error(text.error().text);
    return kUsage;
  }
  const auto& action = options.action;
  const auto outcome = session.command(island, settings.command(), *text);
  nlohmann::json status = nlohmann::json::object();
  for (const auto& tuple : session.read({island, settings.status()})) status = model::object_of(tuple.value);
  const bool carried_out = model::text_of(status, "what") == action && outcome.state != "timed-out";
  if (session.json()) {
    status["island"] = number(island);
    session.out().line(model::dump(status));
  } else if (carried_out && (outcome.good() || !status["errors"].empty())) {
    print_outcome(session, status);
    if (options.try_only || !outcome.good()) print_patch(session, status);
  } else {
    print_error(fmt::format("{}: {}", outcome.state, printable(outcome.reason)));
  }
  return exit_code_of(outcome.state);
}

int run_settings(Session& session, const IslandSettings& options) {
  const auto key = model::IslandKey{session.settings().prefix}.settings();
  const auto island = choose_island(session, options.island, key.status(), "configuration");
  if (island.code != kGood) return island.code;
  return options.action == "show" ? show_settings(session, island.id, key)
                                  : reload_settings(session, island.id, key, options);
}

}  // namespace

void add_settings(Cli& cli) {
  const auto options = std::make_shared<IslandSettings>();
  auto* app = cli.command_in_ecology(
      {"settings", "Show the configuration of an island; check, reload or change its file",
       "  rubicon settings                       # without secrets\n"
       "  rubicon settings try                   # what a reload would change\n"
       "  rubicon settings reload --island 6541\n"
       "  rubicon settings add knx-hall '{type: knx, host: 192.168.1.10}' --groups hall.yaml --try\n"
       "  rubicon settings import knx-hall hall.yaml   # another group file\n"
       "  rubicon settings undo                  # back to the previous file\n"},
      [options](Session& session) {
        return with_island(session, options->island, [&] { return run_settings(session, *options); });
      });
  app->add_option("ACTION", options->action, "show, try, reload, add, import or undo")
      ->check(CLI::IsMember({"show", "try", "reload", "add", "import", "undo"}));
  app->add_option("NETWORK", options->network, "that is added, or gets a group file");
  app->add_option("OPTIONS", options->what, "of the new network, a map in YAML; of `import`: the group file");
  app->add_option("--groups", options->groups, "group file of the new network (`rubicon knx import` writes one)")
      ->type_name("FILE");
  app->add_flag("--try", options->try_only, "say what it would do, and the patch");
  options->island.add_to(app);
}

}  // namespace rubicon::cli
