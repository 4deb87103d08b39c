#include <fmt/format.h>

#include <filesystem>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/commands/history_question.h"
#include "apps/rubicon/output/table.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "history/history_source.h"
#include "history/import.h"
#include "history/past.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/point_keys.h"
#include "recording/record.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::cli {

namespace {

using history::Store;

struct HistoryOptions {
  IslandOption island{};
  std::string file{}, recording{}, from{}, to{};
  std::vector<std::string> patterns{}, exclude{}, ends{};
  std::size_t buckets = 50;
  bool csv = false;
};

WallTime clock_now() {
  return transport::Loop().scheduler().wall_now();
}

int failed(const Error& error) {
  print_error(error.text);
  return kFailed;
}

using Work = std::function<int(Store&, const Settings&, const HistoryOptions&)>;

/// The file of the history that an island keeps, where no file has that name but an island of this host has.
std::string file_of(const Settings& settings, const std::string& word) {
  std::error_code error;
  if (std::filesystem::exists(word, error) || word.find('/') != word.npos) return word;
  const auto session = Session::open(settings, "history");
  if (!session) return word;
  for (const auto island : components_called(*session, word)) {
    const auto status = model::IslandKey{settings.prefix}.history().status();
    for (const auto& tuple : session->read({island, status})) {
      if (auto file = model::text_of(model::object_of(tuple.value), "file"); !file.empty()) return file;
    }
  }
  return word;
}

/// Opens the file for one of the commands.
int with_store(const Settings& settings, const HistoryOptions& options, sqlite::FileUse use, const Work& work,
               bool create = false) {
  const auto file = create ? options.file : file_of(settings, options.file);
  const auto store = Store::open(file, use, use == sqlite::FileUse::kOwn, create);
  if (!store) return failed(store.error());
  if (use == sqlite::FileUse::kOwn && (*store)->read_only())
    return failed({ErrorCode::kRefused, fmt::format("history {}: no permission to write", options.file)});
  return work(**store, settings, options);
}

Result<std::int64_t> number_in(Store& store, const char* sql) {
  return store.database().number(sql, "measuring");
}

int info(Store& store, const Settings& settings, const HistoryOptions&) {
  const auto blocks = number_in(store, "SELECT count(*) FROM block");
  const auto points = number_in(store, "SELECT coalesce(sum(count),0) FROM block");
  const auto packed = number_in(store, "SELECT coalesce(sum(length(data)),0) FROM block");
  const auto hours = number_in(store, "SELECT count(*) FROM hour");
  const auto texts = number_in(store, "SELECT count(*) FROM text");
  for (const auto* one : {&blocks, &points, &packed, &hours, &texts}) {
    if (!*one) return failed(one->error());
  }
  std::int64_t open = 0;
  for (const auto& [row, one] : store.series()) open += static_cast<std::int64_t>(one.open.size());
  std::error_code ignored;
  const auto size = std::filesystem::file_size(store.path(), ignored);
  Output out(1);
  if (settings.json) {
    out.line(
        model::dump(nlohmann::ordered_json{{"file", store.path()},
                                           {"bytes", size},
                                           {"series", store.series().size()},
                                           {"points", *points},
                                           {"open", open},
                                           {"blocks", *blocks},
                                           {"block_bytes", *packed},
                                           {"hours", *hours},
                                           {"texts", *texts},
                                           {"written", base::to_seconds(history::from_milliseconds(store.alive()))},
                                           {"damaged", store.damaged()}}));
    return ended(out, kGood);
  }
  out.line(fmt::format("file: {} ({} bytes)", store.path(), size));
  out.line(fmt::format("series: {}", store.series().size()));
  out.line(fmt::format("points: {} in {} blocks of {} bytes, {} not in blocks yet", *points, *blocks, *packed, open));
  out.line(fmt::format("summaries of hours: {}, texts: {}", *hours, *texts));
  out.line(fmt::format("last written: {}", time_text(history::from_milliseconds(store.alive()))));
  out.line(store.damaged() == 0 ? "damage: none" : fmt::format("damage: {} rows cannot be read", store.damaged()));
  return ended(out, kGood);
}

/// The series that the patterns name; all if there are none.
Result<std::vector<history::SeriesEntry>> chosen(Store& store, const std::vector<std::string>& patterns) {
  std::vector<history::SeriesEntry> all;
  const auto selections = parse_selections(patterns, "*:**", "value");
  if (!selections) return fail(selections.error());
  for (const auto& selection : *selections) {
    auto some = history::list_series(store, selection.pattern);
    if (!some) return some;
    for (auto& one : *some) {
      const bool fresh =
          std::none_of(all.begin(), all.end(), [&](const auto& other) { return other.name == one.name; });
      if (fresh && selection.fits(one.name.owner, one.name.key)) all.push_back(std::move(one));
    }
  }
  return all;
}

int list(const std::vector<history::SeriesEntry>& series, const Settings& settings) {
  Output out(1);
  if (settings.json) {
    out.line(history::to_json(series));
    return ended(out, kGood);
  }
  Table table({{"SERIES", Column::Kind::kKey}, {"KIND"}, {"UNIT"}, {"FROM"}, {"TO"}});
  for (const auto& one : series) {
    table.row({history::to_string(one.name), std::string(to_string(one.kind)), one.unit, time_text(one.first),
               time_text(one.last)});
  }
  out.write(table.text({out.has_colour(), out.width()}));
  return ended(out, kGood);
}

std::string number_text(double value) {
  return fmt::format("{:.6g}", value);
}

void add_rows(const history::SeriesAnswer& series, Table& table) {
  for (const auto& bucket : series.buckets) {
    const auto place = static_cast<std::size_t>(std::max(bucket.last, 0.0));
    const bool word = series.kind == history::SeriesKind::kWords && place < series.words.size();
    table.row({time_text(bucket.time), std::to_string(bucket.count), number_text(bucket.minimum),
               number_text(bucket.maximum), number_text(bucket.mean),
               word ? series.words[place] : number_text(bucket.last)});
  }
  for (const auto& text : series.texts) table.row({time_text(text.time), "1", "", "", "", text.text});
}

void show(const history::Answer& answer, const Settings& settings, const HistoryOptions& options, Output& out) {
  if (settings.json) return out.line(history::to_json(answer));
  if (options.csv) return out.write(history::to_csv(answer));
  for (const auto& one : answer.series) {
    out.line(fmt::format("{}{}{}", history::to_string(one.name), one.unit.empty() ? "" : ", ", one.unit));
    Table table({{"TIME"}, {"VALUES"}, {"MINIMUM"}, {"MAXIMUM"}, {"MEAN"}, {"LAST", Column::Kind::kText}});
    add_rows(one, table);
    out.write(table.text({out.has_colour(), out.width()}));
  }
}

int query(Store& store, const Settings& settings, const HistoryOptions& options) {
  const auto series = chosen(store, options.patterns);
  if (!series) return failed(series.error());
  if (series->empty()) {
    print_error("no series fits; without a pattern `rubicon history FILE query` lists them all");
    return kNotThere;
  }
  if (options.patterns.empty()) return list(*series, settings);
  const auto now = clock_now();
  history::Question question{{}, *time_in(options.from, now), *time_in(options.to, now), options.buckets};
  for (const auto& one : *series) question.series.push_back(one.name);
  const auto answer = history::answer(store, question);
  if (!answer) return failed(answer.error());
  Output out(1);
  show(*answer, settings, options, out);
  return ended(out, kGood);
}

/// Asks an island, in place of a file.
int ask(Session& session, HistoryOptions options) {
  std::error_code error;
  if (std::filesystem::is_regular_file(options.file, error)) {
    print_error(fmt::format("{} is a file: expected info, query, export, compact or import behind it", options.file));
    return kUsage;
  }
  if (const int code = options.island.put_before(session, options.file); code != kGood) return code;
  const auto from = *time_in(options.from, session.now()), to = *time_in(options.to, session.now());
  if (from >= to) {
    print_error("--from: expected a time before --to");
    return kUsage;
  }
  history::Answer answer;
  if (const int code = ask_history(session, {options.file}, from, to, options.buckets, answer); code != kGood)
    return code;
  show(answer, session.settings(), options, session.out());
  return kGood;
}

int export_points(Store& store, const Settings&, const HistoryOptions& options) {
  const auto series = chosen(store, options.patterns);
  if (!series) return failed(series.error());
  const auto now = clock_now();
  const auto from = options.from.empty() ? -history::kFurthest : history::to_milliseconds(*time_in(options.from, now));
  const auto to = options.to.empty() ? history::kFurthest : history::to_milliseconds(*time_in(options.to, now));
  Output out(1);
  out.write(history::kPointHeader);
  std::string line;
  const auto put = [&](const history::SeriesName& name, WallTime time, std::string_view value) {
    line.clear();
    history::append_point_line(name, time, value, line);
    out.write(line);
    return !out.broken();
  };
  for (const auto& one : *series) {
    const auto row = *store.find(one.name);
    auto done = history::each_point(store, row, from, to, [&](const history::Point& point) {
      return put(one.name, history::from_milliseconds(point.time), history::value_text(one, point));
    });
    if (done) {
      done = history::each_text(store, row, from, to,
                                [&](const history::TextValue& text) { return put(one.name, text.time, text.text); });
    }
    if (!done) return failed(done.error());
  }
  if (store.damaged() > 0)
    print_error(fmt::format("{} rows cannot be read; their points are missing", store.damaged()));
  return ended(out, kGood);
}

int compact(Store& store, const Settings&, const HistoryOptions&) {
  std::error_code ignored;
  const auto before = std::filesystem::file_size(store.path(), ignored);
  auto done = store.close_all();
  if (done) done = store.database().run("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)", "compacting");
  if (!done) return failed(done.error());
  Output out(1);
  out.line(
      fmt::format("{}: {} bytes, before {}", store.path(), std::filesystem::file_size(store.path(), ignored), before));
  return ended(out, kGood);
}

void tell_import(const history::Imported& done, const Settings& settings, const HistoryOptions& options, Output& out) {
  if (settings.json) {
    return out.line(model::dump(nlohmann::ordered_json{
        {"records", done.records}, {"points", done.points}, {"unfit", done.unfit}, {"damage", done.damage}}));
  }
  out.line(fmt::format("{} points of {} records from {} to {}", done.points, done.records,
                       recording::utc_text(done.first), recording::utc_text(done.last)));
  if (done.damage > 0) print_error(fmt::format("{} parts of {} are damaged", done.damage, options.recording));
}

int import(Store& store, const Settings& settings, const HistoryOptions& options) {
  history::ImportRules rules;
  if (!options.patterns.empty()) rules.patterns = patterns_in(options.patterns);
  rules.exclude = patterns_in(options.exclude);
  transport::LocalTransports files;
  Output out(1);
  const auto now = clock_now();
  for (const auto& end : options.ends.empty() ? std::vector<std::string>{""} : options.ends) {
    if (!end.empty()) rules.end = *time_in(end, now);
    const auto done = history::import_recording(store, files, options.recording, rules);
    if (!done) return failed(done.error());
    tell_import(*done, settings, options, out);
  }
  return ended(out, kGood);
}

std::string check_selection(const std::string& text) {
  const auto parsed = parse_selections(text, "value");
  return parsed ? std::string() : parsed.error().text;
}

void add_patterns(CLI::App* app, std::vector<std::string>& patterns, const std::string& about) {
  app->add_option("PATTERN", patterns, about)->check(check_selection);
}

/// Which part of the past, and how.
void add_question(CLI::App* app, HistoryOptions& options) {
  options.from = "1h";
  options.to = "now";
  add_time_option(app, "--from", options.from, "begin; default: 1h, an hour ago");
  add_time_option(app, "--to", options.to, "end; default: now");
  app->add_option("--buckets", options.buckets, "most rows of a series")
      ->check(CLI::Range(std::size_t{1}, history::kMaxBuckets))
      ->capture_default_str();
  app->add_flag("--csv", options.csv, "as CSV");
}

/// The command itself, which asks an island; those of a file stand below it.
CLI::App* add_parent(Cli& cli, const std::shared_ptr<HistoryOptions>& options) {
  const auto of_island = std::make_shared<HistoryOptions>();
  auto* parent = cli.command_in_ecology(
      {"history", "Show past values of a tuple; look into the file of a history: info, query, export, compact, import",
       "  rubicon history living.light-1\n"
       "  rubicon history 'Living room.light' --from 1d --csv > light.csv\n"
       "  rubicon history demo.history info\n"
       "A tuple is asked for at the island that keeps a history. An island or `rubicon web` may write the file\n"
       "meanwhile, except for compact and import.\n"},
      [options, of_island](Session& session) {
        of_island->file = options->file;
        return ask(session, *of_island);
      });
  parent->fallthrough();
  parent->get_formatter()->label("SUBCOMMAND", "COMMAND");
  parent
      ->add_option(
          "TUPLE", options->file,
          "key, or DEVICE.POINT by key or name; in front of a command the file of a history, or the id or name of an "
          "island on this host that keeps one")
      ->required();
  of_island->island.add_to(parent);
  add_question(parent, *of_island);
  return parent;
}

}  // namespace

void add_history(Cli& cli) {
  const auto options = std::make_shared<HistoryOptions>();
  auto* parent = add_parent(cli, options);
  const auto add = [&](const Cli::Text& text, sqlite::FileUse use, const Work& work) {
    return cli.command(
        {text.name, text.summary, text.examples, parent},
        [options, use, work](const Settings& settings) { return with_store(settings, *options, use, work); });
  };
  add({"info", "Show sizes and times", "  rubicon history demo.history info\n"}, sqlite::FileUse::kRead, info);
  auto* ask_file = add({"query", "Show the past values of series, or list the series",
                        "  rubicon history demo.history query\n"
                        "  rubicon history demo.history query '6541:proxy.*.*.sensor.temperature-1.value' --from 1d\n"
                        "  rubicon history demo.history query '*.temperature-1' --from 1d\n"},
                       sqlite::FileUse::kRead, query);
  add_patterns(ask_file, options->patterns, "series to show; default: a list of all");
  add_question(ask_file, *options);
  const auto every = std::make_shared<HistoryOptions>();
  auto* points = cli.command({"export", "Write all values as CSV",
                              "  rubicon history demo.history export '*:proxy.wsn-flat.**' > motes.csv\n", parent},
                             [options, every](const Settings& settings) {
                               every->file = options->file;
                               return with_store(settings, *every, sqlite::FileUse::kRead, export_points);
                             });
  add_patterns(points, every->patterns, "series to write; default: all");
  add_time_option(points, "--from", every->from, "begin; default: the first value");
  add_time_option(points, "--to", every->to, "end; default: the last value");
  add({"compact", "Give the space of removed values back to the disk", "  rubicon history demo.history compact\n"},
      sqlite::FileUse::kOwn, compact);
  auto* fill =
      cli.command({"import", "Fill it from a recording",
                   "  rubicon history demo.history import examples/recordings/demo_hour.rec --end now\n", parent},
                  [options, every](const Settings& settings) {
                    every->file = options->file;
                    return with_store(settings, *every, sqlite::FileUse::kOwn, import, true);
                  });
  fill->add_option("RECORDING", every->recording, "file that a recorder wrote")->required();
  fill->add_option("--pattern", every->patterns, "values to take (may be repeated); default: all of points")
      ->check(check_pattern)
      ->allow_extra_args(false);
  fill->add_option("--exclude", every->exclude, "but not these (may be repeated)")
      ->check(check_pattern)
      ->allow_extra_args(false);
  fill->add_option(
          "--end", every->ends,
          "shift all times so that the recording ends at this time; default: no shift. May be repeated, oldest "
          "first: it is imported once for each")
      ->type_name("TIME")
      ->check(check_time)
      ->allow_extra_args(false);
}

}  // namespace rubicon::cli
