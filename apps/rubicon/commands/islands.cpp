#include <fmt/format.h>

#include <numeric>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/doctor/signs.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "base/compare_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

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

namespace {

using client::Network;

struct NetworksOptions {
  IslandOption island;
  std::string network, action, length;
};

using Name = std::pair<OwnerId, std::string>;

Line network_json(const Network& network, const Counters& counters, const Counters& growth) {
  Line line;
  line["island"] = number(network.island);
  line["key"] = model::IslandKey{network.prefix}.network(network.id).text;
  line["network"] = network.id;
  line["type"] = network.type();
  line["line"] = network.line.line;
  line["since"] = base::to_seconds(network.line.since);
  line["reason"] = network.line.reason;
  line["attempts"] = network.line.attempts;
  line["next_attempt"] = base::to_seconds(network.line.next_attempt);
  line["devices"] = network.devices;
  line["reachable"] = network.reachable;
  line["losses"] = losses_of(counters);
  line["counters"] = counters;
  if (!growth.empty()) line["grew"] = growth;
  return line;
}

std::string next_of(const LineStatus& line, WallTime now) {
  if (line.works() || line.next_attempt == WallTime{}) return "";
  return line.next_attempt <= now ? "now" : age_text(now, line.next_attempt);
}

int list(Session& session, const NetworksOptions& options) {
  session.discover();
  std::vector<std::string> ids;
  const auto look = [&] {
    auto found = session.client().networks(options.island.owner(), session.settings().patience);
    for (const auto& one : found) ids.push_back(one.id);
    std::erase_if(found, [&](const Network& one) { return !options.network.empty() && one.id != options.network; });
    return found;
  };
  std::map<Name, Counters> before;
  if (!options.length.empty()) {
    for (const auto& network : look()) before[{network.island, network.id}] = counters_of(network.properties);
    session.run([] { return false; }, parse_duration_or(options.length));
  }
  using Kind = Column::Kind;
  Table table({{"NETWORK", Kind::kKey},
               {"TYPE", Kind::kWord, 3},
               {"LINE"},
               {"SINCE", Kind::kWord, 2},
               {"NEXT TRY", Kind::kWord, 1},
               {"DEVICES"},
               {"LOST", Kind::kText},
               {"REASON", Kind::kText}});
  for (const auto& network : look()) {
    const auto counters = counters_of(network.properties);
    const auto known = before.find({network.island, network.id});
    const auto growth = known == before.end() ? Counters() : growth_of(known->second, counters);
    if (session.json()) session.out().line(model::dump(network_json(network, counters, growth)));
    table.row({name_of(network.island, network.id), network.type(), network.line.line,
               age_text(network.line.since, session.now()), next_of(network.line, session.now()),
               fmt::format("{}/{}", network.reachable, network.devices), losses_text(losses_of(counters), growth),
               network.line.reason});
  }
  if (table.empty())
    return session.not_found(options.network.empty() ? "no network" : "no network " + model::quoted(options.network),
                             base::did_you_mean(options.network, ids));
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

int reopen(Session& session, const NetworksOptions& options) {
  const auto what = "network " + model::quoted(options.network);
  if (model::to_key_part(options.network) != options.network) return session.not_found("no " + what);
  const auto line = model::IslandKey{session.settings().prefix}.network(options.network).line();
  const auto island = choose_island(session, options.island, line.status(), what);
  if (island.code != kGood) return island.code;
  return command_island(session, island.id, line.command(), options.action, options.network + ": the line is up");
}

}  // namespace

void add_networks(Cli& cli) {
  const auto options = std::make_shared<NetworksOptions>();
  auto* app = cli.command_in_ecology(
      {"networks", "List the networks: line state, reason, next attempt, devices, losses; reopen a line",
       "  rubicon networks\n"
       "  rubicon networks --for 10s                   # and the losses within ten seconds\n"
       "  rubicon networks --island 6541 --json        # all counters\n"
       "  rubicon networks knx-demo reopen             # try now to open a line that is down\n"
       "DEVICES: reachable devices of all devices. LOST: counters of dropped, refused and malformed messages\n"
       "since the island started.\n"},
      [options](Session& session) {
        return with_network(session, options->island, options->network, [&] {
          return options->action.empty() ? list(session, *options) : reopen(session, *options);
        });
      });
  app->add_option("NETWORK", options->network, "this network only, also with its island in front: 6541:knx-demo");
  app->add_option("ACTION", options->action, "reopen: try now to open the line, not after the pause")
      ->check(CLI::IsMember({"reopen"}));
  options->island.add_to(app);
  add_duration_option(app, "--for", options->length,
                      "compare two observations this far apart, and show which losses grew");
}

}  // namespace rubicon::cli
