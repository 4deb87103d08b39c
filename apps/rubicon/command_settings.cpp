#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_points.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

struct IslandSettings {
  IslandOption island;
  std::string action = "show";
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

int reload_settings(Session& session, OwnerId island, const model::PointKey& settings, const std::string& action) {
  const auto outcome = session.client().command(island, settings.command(), action);
  nlohmann::json status = nlohmann::json::object();
  for (const auto& tuple : session.read({island, settings.status()})) status = model::object_of(tuple.value);
  const bool carried_out = model::text_of(status, "what") == action && outcome.state != "timed-out";
  if (session.json()) {
    status["island"] = number(island);
    session.out().line(model::dump(status));
  } else if (carried_out && (outcome.good() || !status["errors"].empty())) {
    print_outcome(session, status);
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
                                  : reload_settings(session, island.id, key, options.action);
}

}  // namespace

void add_settings(Cli& cli) {
  const auto options = std::make_shared<IslandSettings>();
  auto* app = cli.command_in_ecology({"settings", "Show the configuration of an island; check or reload its file",
                                      "  rubicon settings                       # without secrets\n"
                                      "  rubicon settings try                   # what a reload would change\n"
                                      "  rubicon settings reload --island 6541\n"},
                                     [options](Session& session) {
                                       return with_island(session, options->island,
                                                          [&] { return run_settings(session, *options); });
                                     });
  app->add_option("ACTION", options->action, "show, try or reload")->check(CLI::IsMember({"show", "try", "reload"}));
  options->island.add_to(app);
}

}  // namespace rubicon::cli
