#include <fmt/format.h>

#include <numeric>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"

namespace rubicon::cli {

namespace {

std::uint64_t devices_of(const Summary& summary) {
  return std::accumulate(summary.networks.begin(), summary.networks.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& network) { return sum + network.second; });
}

std::string networks_of(const Summary& summary) {
  std::string names;
  for (const auto& [id, devices] : summary.networks) names += (names.empty() ? "" : " ") + id;
  return names;
}

Line component_json(const client::Component& one) {
  Line line;
  line["id"] = number(one.id);
  line["name"] = one.summary.name;
  line["host"] = one.summary.host;
  line["program"] = one.summary.program;
  if (model::is_island(one.id, one.summary)) {
    line["prefix"] = one.summary.prefix;
    line["networks"] = one.summary.networks;
    line["devices"] = devices_of(one.summary);
  }
  line["since"] = base::to_seconds(one.summary.since);
  return line;
}

int list(Session& session, bool all) {
  session.discover();
  auto& client = session.client();
  const auto found = all ? client.components() : client.islands();
  using Kind = Column::Kind;
  Table table({{"ID"},
               {"NAME", Kind::kText},
               {"HOST", Kind::kText, 2},
               {"PROGRAM", Kind::kText, 3},
               {"UP", Kind::kWord, 1},
               {"DEVICES"},
               {"NETWORKS", Kind::kText}});
  for (const auto& one : found) {
    if (session.json()) session.out().line(model::dump(component_json(one)));
    const bool island = model::is_island(one.id, one.summary);
    table.row({std::to_string(number(one.id)), one.summary.name, one.summary.host, one.summary.program,
               age_text(one.summary.since, session.now()), island ? std::to_string(devices_of(one.summary)) : "",
               networks_of(one.summary)});
  }
  if (table.empty()) return session.not_found(all ? "no component" : "no island");
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

}  // namespace

void add_islands(Cli& cli) {
  const auto all = std::make_shared<bool>(false);
  auto* app = cli.command_in_ecology({"islands", "List the islands: name, host, networks, number of devices",
                                      "  rubicon islands\n"
                                      "  rubicon islands --all --json     # robots and tools too\n"},
                                     [all](Session& session) { return list(session, *all); });
  app->add_flag("--all", *all, "all components, not only islands");
}

}  // namespace rubicon::cli
