#include <fmt/format.h>

#include <map>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_points.h"
#include "apps/rubicon/tuple_text.h"
#include "base/local_time.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

struct ReplayOptions {
  IslandOption island;
  std::string network, action, value;
};

/// The properties `replay-...` of one network, without that prefix.
using Replay = std::map<std::string, std::string>;

std::map<std::pair<OwnerId, std::string>, Replay> replays_of(Session& session, const ReplayOptions& options) {
  std::map<std::pair<OwnerId, std::string>, Replay> found;
  constexpr std::string_view kPrefix = "replay-";
  const auto any = model::IslandKey{session.settings().prefix}.network("*").property("*");
  for (const auto& tuple : session.read({options.island.owner(), any})) {
    const auto parts = model::key_parts(tuple.key);
    if (parts.size() != 5 || !parts[3].starts_with(kPrefix)) continue;
    if (!options.network.empty() && parts[1] != options.network) continue;
    found[{tuple.owner, std::string(parts[1])}][std::string(parts[3].substr(kPrefix.size()))] = tuple.value;
  }
  return found;
}

/// Positions of recordings with absolute times are seconds since 1970, those of others seconds since their beginning.
std::string position_text(const std::string& seconds) {
  constexpr double kLongest = 366.0 * 24 * 3600;
  const auto number = base::parse_number<double>(seconds);
  return number && *number > kLongest ? base::local_text(model::time_from_seconds(*number)) : seconds;
}

int list_replays(Session& session, const ReplayOptions& options) {
  using Kind = Column::Kind;
  Table table({{"ISLAND"},
               {"NETWORK", Kind::kKey},
               {"STATE"},
               {"SPEED"},
               {"POSITION", Kind::kText},
               {"BEGIN", Kind::kText, 1},
               {"END", Kind::kText, 2}});
  for (auto& [name, replay] : replays_of(session, options)) {
    if (session.json()) {
      Line line{{"island", number(name.first)}, {"network", name.second}};
      for (const auto& [member, value] : replay) line[member] = value;
      session.out().line(model::dump(line));
    }
    table.row({session.component_text(name.first), name.second, replay["state"], replay["speed"],
               position_text(replay["position"]), position_text(replay["begin"]), position_text(replay["end"])});
  }
  if (table.empty()) {
    return session.not_found(options.network.empty() ? "no network that plays a recording"
                                                     : "no recording in network " + model::quoted(options.network));
  }
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

struct Order {
  std::string property, text;
};

Result<Order> order_of(const ReplayOptions& options) {
  const bool takes_value = options.action == "speed" || options.action == "seek";
  if (takes_value != !options.value.empty())
    return fail(ErrorCode::kInvalid, fmt::format("{} takes {}", options.action,
                                                 !takes_value ? "no value"
                                                 : options.action == "speed"
                                                     ? "a factor, or max"
                                                     : "a time: seconds, a date, 90s from the beginning, +30s, -30s"));
  if (options.action == "speed") return Order{"replay-speed", options.value};
  if (options.action == "seek") return Order{"replay-position", options.value};
  return Order{"replay-state", options.action == "play" ? "playing" : "paused"};
}

int control_replay(Session& session, const ReplayOptions& options) {
  const auto order = order_of(options);
  if (!order) {
    print_error(order.error().text);
    return kUsage;
  }
  const auto what = "recording in network " + model::quoted(options.network);
  if (model::to_key_part(options.network) != options.network) return session.not_found("no " + what);
  const auto point = model::IslandKey{session.settings().prefix}.network(options.network).control(order->property);
  const auto island = choose_island(session, options.island, point.status(), what);
  if (island.code != kGood) return island.code;
  return command_island(session, island.id, point.command(), order->text,
                        fmt::format("{}: {} {}", options.network, order->property, order->text));
}

}  // namespace

void add_replay(Cli& cli) {
  const auto options = std::make_shared<ReplayOptions>();
  auto* app = cli.command_in_ecology({"replay", "Show the recordings that islands play; pause, speed up or search one",
                                      "  rubicon replay\n"
                                      "  rubicon replay log-flat pause\n"
                                      "  rubicon replay log-flat seek 90s             # from the beginning\n"
                                      "  rubicon replay log-flat seek -- -30s         # back from here\n"
                                      "  rubicon replay log-flat play\n"
                                      "  rubicon replay log-flat speed 2\n"},
                                     [options](Session& session) {
                                       return with_network(session, options->island, options->network, [&] {
                                         return options->action.empty() ? list_replays(session, *options)
                                                                        : control_replay(session, *options);
                                       });
                                     });
  app->add_option("NETWORK", options->network, "a network of type log");
  app->add_option("ACTION", options->action, "play, pause, speed or seek")
      ->check(CLI::IsMember({"play", "pause", "speed", "seek"}));
  app->add_option("VALUE", options->value, "of speed: a factor or max; of seek: a time");
  options->island.add_to(app);
}

}  // namespace rubicon::cli
