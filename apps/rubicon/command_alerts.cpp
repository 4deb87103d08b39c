#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_option.h"
#include "apps/rubicon/tuple_text.h"
#include "model/alerts.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

void show(Session& session, OwnerId island, const model::Alert& alert, Table& table) {
  if (session.json()) {
    session.out().line(model::dump({{"island", number(island)},
                                    {"kind", alert.kind},
                                    {"about", alert.about},
                                    {"severity", to_string(alert.severity)},
                                    {"since", model::seconds_json(alert.since)},
                                    {"what", alert.what},
                                    {"fix", alert.fix}}));
    return;
  }
  table.row({std::string(to_string(alert.severity)), age_text(alert.since, session.now()),
             session.component_text(island), alert.what, alert.fix});
}

int list(Session& session, const IslandOption& island) {
  using Kind = Column::Kind;
  Table table({{"SEVERITY"},
               {"SINCE", Kind::kWord, 2},
               {"ISLAND", Kind::kWord, 1},
               {"WHAT", Kind::kText},
               {"WHAT TO DO", Kind::kText}});
  const auto found = session.read({island.owner(), model::IslandKey{session.settings().prefix}.alerts()});
  std::uint64_t more = 0;
  for (const auto& tuple : found) {
    const auto alerts = model::alerts_from_json(tuple.value);
    for (const auto& one : alerts.all) show(session, tuple.owner, one, table);
    more += alerts.more;
  }
  if (found.empty()) return session.not_found("no island");
  if (session.json()) return kGood;
  session.out().write(table.empty() ? "nothing needs attention\n" : table.text(session.look()));
  if (more > 0) session.out().line(fmt::format("and {} more", more));
  return kGood;
}

}  // namespace

void add_alerts(Cli& cli) {
  const auto island = std::make_shared<IslandOption>();
  auto* app = cli.command_in_ecology(
      {"alerts", "List what needs a person: lines that are down, silent devices, low batteries, full disks",
       "  rubicon alerts\n"
       "  rubicon alerts --island 6541 --json\n"},
      [island](Session& session) { return with_island(session, *island, [&] { return list(session, *island); }); });
  island->add_to(app);
}

}  // namespace rubicon::cli
