#include <fmt/format.h>

#include <filesystem>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_option.h"
#include "apps/rubicon/tuple_text.h"
#include "apps/rubicon/woken.h"
#include "model/json_members.h"
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

/// What the recorder complains about.
class Complaints final : public base::LogSink {
 public:
  void write(base::LogLevel level, std::string_view, std::string_view text) override {
    if (level >= base::LogLevel::kWarning) print_error(text);
  }
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

Result<std::vector<Pattern>> patterns_of(Session& session, const RecordOptions& options, OwnerId island) {
  std::vector<Pattern> patterns;
  for (const auto& text : with_island_ids(session, options.patterns)) {
    auto pattern = Pattern::parse(text);
    if (!pattern) return fail(pattern.error());
    patterns.push_back(std::move(*pattern));
  }
  if (patterns.empty()) patterns.push_back({island, session.settings().prefix + ".**"});
  return patterns;
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
  const auto patterns = patterns_of(session, options, island);
  if (!patterns) {
    print_error(patterns.error().text);
    return kUsage;
  }
  config::RecorderSetup setup;
  setup.name = "record";
  setup.file = options.file;
  setup.patterns = *patterns;
  setup.active = options.active;
  setup.minimum = parse_duration_or(options.minimum);
  setup.rotation = {std::nullopt, std::nullopt, std::nullopt};
  Complaints complaints;
  transport::LocalTransports files;
  auto& client = session.client();
  const auto folder = std::filesystem::current_path().string();
  recorder::Recorder recorder(
      setup, {client.scheduler(), client.tuples(), files, complaints, session.settings().prefix, folder, island});
  recorder.start();
  if (recorder.counters().failures > 0) return kFailed;
  if (options.active) {
    Selections woken;
    for (const auto& pattern : *patterns) woken.push_back({pattern, to_string(pattern)});
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
       "  rubicon-proxy recording home.rec export --csv\n"},
      [options](Session& session) {
        return with_island(session, options->island, [&] { return record(session, *options); });
      });
  app->add_option("FILE", options->file, "a new file, or a recording of the same island that goes on")->required();
  app->add_option("PATTERN", options->patterns, "which tuples; everything of the island if none");
  options->island.add_to(app, "whose recording it is: id or name");
  app->add_flag("--active", options->active, "wake the sensors, so that they measure");
  add_duration_option(app, "--min-interval", options->minimum, "at most one record of a tuple in this time");
  add_duration_option(app, "--for", options->length, "end after this time");
}

}  // namespace rubicon::cli
