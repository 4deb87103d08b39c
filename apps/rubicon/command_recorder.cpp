#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_points.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

struct RecorderOptions {
  IslandOption island;
  std::string name, action, text;
};

int list_recorders(Session& session, const RecorderOptions& options) {
  using Kind = Column::Kind;
  Table table({{"ISLAND"},
               {"RECORDER", Kind::kKey},
               {"STATE"},
               {"SINCE", Kind::kWord, 3},
               {"BYTES", Kind::kWord, 1},
               {"RECORDS", Kind::kWord, 2},
               {"DROPPED"},
               {"FILE", Kind::kText},
               {"REASON", Kind::kText}});
  const model::IslandKey island{session.settings().prefix};
  for (const auto& tuple : session.read({options.island.owner(), island.recorder("*").status()})) {
    const auto about = model::object_of(tuple.value);
    const std::string name(model::last_part(model::parent_key(tuple.key)));
    if (!options.name.empty() && name != options.name) continue;
    if (session.json()) {
      auto line = about;
      line["island"] = number(tuple.owner);
      line["recorder"] = name;
      session.out().line(model::dump(line));
    }
    const auto count = [&](const char* member) { return std::to_string(model::count_of(about, member)); };
    table.row({session.component_text(tuple.owner), name, model::text_of(about, "state"),
               age_text(model::time_of(about, "since"), session.now()), count("size"), count("records"),
               count("dropped"), model::text_of(about, "file"), model::text_of(about, "reason")});
  }
  if (table.empty())
    return session.not_found(options.name.empty() ? "no recorder" : "no recorder " + model::quoted(options.name));
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

int command_recorder(Session& session, const RecorderOptions& options) {
  if (!options.text.empty() && options.action != "mark") {
    print_error(fmt::format("{} takes no text", options.action));
    return kUsage;
  }
  if (model::to_key_part(options.name) != options.name)
    return session.not_found("no recorder " + model::quoted(options.name));
  const auto point = model::IslandKey{session.settings().prefix}.recorder(options.name);
  const auto island = choose_island(session, options.island, point.status(), "recorder " + options.name);
  if (island.code != kGood) return island.code;
  const auto text = options.text.empty() ? options.action : options.action + " " + options.text;
  const auto* done = options.action == "start" ? "records" : options.action == "stop" ? "is stopped" : "is marked";
  return command_island(session, island.id, point.command(), text, fmt::format("{} {}", options.name, done));
}

}  // namespace

void add_recorder(Cli& cli) {
  const auto options = std::make_shared<RecorderOptions>();
  auto* app = cli.command_in_ecology({"recorder", "List the recorders of islands; start, stop or mark one",
                                      "  rubicon recorder\n"
                                      "  rubicon recorder all mark 'the lamp was replaced'\n"
                                      "  rubicon recorder all stop\n"
                                      "  rubicon recorder all start\n"},
                                     [options](Session& session) {
                                       return with_island(session, options->island, [&] {
                                         return options->action.empty() ? list_recorders(session, *options)
                                                                        : command_recorder(session, *options);
                                       });
                                     });
  app->add_option("NAME", options->name, "a recorder of the configuration");
  app->add_option("ACTION", options->action, "start, stop or mark")->check(CLI::IsMember({"start", "stop", "mark"}));
  app->add_option("TEXT", options->text, "text of a mark, at most 200 bytes");
  options->island.add_to(app);
}

}  // namespace rubicon::cli
