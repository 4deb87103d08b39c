#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/loop_component.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "base/clocks.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "recorder/recorder.h"
#include "transport/local_transports.h"

namespace rubicon::cli {

namespace {

struct RecordOptions {
  std::string file, length, minimum;
  std::vector<std::string> patterns;
  IslandOption island;
  bool active = false;
};

/// The island to record; kNoOwner after the error was printed.
OwnerId island_of(Session& session, const RecordOptions& options) {
  if (const auto named = options.island.owner()) return *named;
  session.discover();
  const auto islands = session.client().islands();
  if (islands.size() == 1) return islands[0].id;
  std::string ids;
  for (const auto& island : islands) ids += fmt::format(" {}", number(island.id));
  if (islands.empty()) {
    std::ignore = session.not_found("no island to record");
  } else {
    print_error(fmt::format("a recording holds one island; choose it with --island:{}", ids));
  }
  return model::kNoOwner;
}

/// kGood, or the exit code after the error was printed. A name that people gave stands for all tuples of the point.
int patterns_of(Session& session, const RecordOptions& options, OwnerId island, std::vector<Pattern>& patterns) {
  Selections selections;
  if (const int code = selections_called(session, options.patterns, "**", selections); code != kGood) return code;
  for (const auto& one : selections) {
    if (one.narrower()) {
      print_error(fmt::format("{}: a recorder knows * for whole parts only", model::quoted(one.text)));
      return kUsage;
    }
    patterns.push_back(one.pattern);
  }
  if (patterns.empty()) patterns.push_back({island, session.settings().prefix + ".**"});
  return kGood;
}

/// What is recorded, where it was named otherwise.
void tell_names(const RecordOptions& options, const std::vector<Pattern>& patterns) {
  const auto is_typed = [&](const std::string& text) {
    return std::find(options.patterns.begin(), options.patterns.end(), text) != options.patterns.end();
  };
  for (const auto& one : patterns) {
    if (one.owner && !options.patterns.empty() && !is_typed(to_string(one)))
      print_error(fmt::format("{} is recorded", to_string(one)));
  }
}

int finish(Session& session, const recorder::Recorder& recorder, const std::string& file) {
  const auto& counters = recorder.counters();
  if (session.json()) {
    session.out().line(model::dump(
        {{"file", file}, {"records", counters.records}, {"bytes", counters.bytes}, {"dropped", counters.dropped}}));
  } else {
    session.out().line(fmt::format("{}: {}, {} written{}", file, counted(counters.records, "record"),
                                   counted(counters.bytes, "byte"),
                                   counters.dropped > 0 ? fmt::format(", {} dropped", counters.dropped) : ""));
  }
  return counters.failures > 0 || counters.dropped > 0 ? kFailed : kGood;
}

int record(Session& session, const RecordOptions& options) {
  const auto island = island_of(session, options);
  if (island == model::kNoOwner) return session.client().islands().empty() ? kNotThere : kUsage;
  std::vector<Pattern> patterns;
  if (const int code = patterns_of(session, options, island, patterns); code != kGood) return code;
  tell_names(options, patterns);
  config::RecorderSetup setup;
  setup.name = "record";
  setup.file = options.file;
  setup.patterns = patterns;
  setup.active = options.active;
  setup.minimum = parse_duration_or(options.minimum);
  setup.rotation = {std::nullopt, std::nullopt, std::nullopt};
  PrintedWarnings complaints;
  transport::LocalTransports files;
  auto& client = session.client();
  const auto folder = std::filesystem::current_path().string();
  recorder::Recorder recorder(
      setup, {client.scheduler(), client.tuples(), files, complaints, session.settings().prefix, folder, island});
  recorder.start();
  if (recorder.counters().failures > 0) return kFailed;
  if (options.active) {
    Selections woken;
    for (const auto& pattern : patterns) woken.push_back({pattern, to_string(pattern)});
    warn_if_many_wake(client, woken);
  }
  session.run([] { return false; }, parse_duration_or(options.length, Duration::max()));
  recorder.flush();
  return finish(session, recorder, options.file);
}

}  // namespace

void add_record(Cli& cli) {
  const auto options = std::make_shared<RecordOptions>();
  auto* app = cli.command_in_ecology(
      {"record", "Record what happens to tuples, until a signal; `rubicon-proxy` plays and exports it",
       "  rubicon record home.rec                          # everything of the only island\n"
       "  rubicon record sensors.rec 'proxy.*.*.sensor.**' --active --for 1h\n"
       "  rubicon record lamp.rec 'Living room.lamp'       # all tuples of a point, by its name\n"
       "  rubicon-proxy recording home.rec export --csv\n"},
      [options](Session& session) {
        return with_island(session, options->island, [&] { return record(session, *options); });
      });
  app->add_option("FILE", options->file, "a new file, or a recording of the same island to continue")->required();
  app->add_option("PATTERN", options->patterns,
                  "which tuples, also DEVICE.POINT by key or name; everything of the island if none");
  options->island.add_to(app, "whose recording it is: id or name");
  app->add_flag("--active", options->active, "wake the sensors, so that they measure");
  add_duration_option(app, "--min-interval", options->minimum, "at most one record of a tuple in this time");
  add_duration_option(app, "--for", options->length, "end after this time");
}

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
  constexpr double kMaxTime = 366.0 * 24 * 3600;
  const auto number = base::parse_number<double>(seconds);
  return number && *number > kMaxTime ? base::local_text(model::time_from_seconds(*number)) : seconds;
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
