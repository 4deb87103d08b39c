#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_points.h"
#include "apps/rubicon/losses.h"
#include "apps/rubicon/tuple_text.h"
#include "base/nearest.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

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
