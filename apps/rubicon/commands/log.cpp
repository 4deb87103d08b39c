#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/doctor/signs.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "base/clocks.h"
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

namespace {

constexpr std::array<std::string_view, 4> kLevels{"debug", "info", "warning", "error"};

struct LogOptions {
  IslandOption island;
  std::string level = "info", length;
  bool follow = false;
};

std::size_t rank_of(std::string_view level) {
  return static_cast<std::size_t>(std::find(kLevels.begin(), kLevels.end(), level) - kLevels.begin());
}

/// Prints each line of each island once.
class LogReader {
 public:
  LogReader(Session& session, const LogOptions& options) : session_(session), options_(options) {}

  int run() {
    const auto key = model::IslandKey{session_.settings().prefix}.log_lines();
    const auto subscription = session_.client().tuples().subscribe({options_.island.owner(), key}, {},
                                                                   [this](const Event& event) { take(event); });
    if (!options_.island.owner()) session_.discover();
    session_.run([this] { return heard_; }, session_.settings().patience);
    if (!heard_) return session_.not_found("no log");
    session_.run([] { return false; }, kPresentLines);
    print_waiting();
    if (!options_.follow || session_.interrupted()) return kGood;
    direct_ = true;
    session_.run([] { return false; }, parse_duration_or(options_.length, Duration::max()));
    return kGood;
  }

 private:
  void take(const Event& event) {
    if (event.kind != EventKind::kSet) return;
    auto news = new_lines_.take(event.tuple);
    heard_ = true;
    if (direct_ && news.missed > 0)
      print_error(fmt::format("{} of island {} were missed", counted(news.missed, "line"), number(event.tuple.owner)));
    for (auto& line : news.lines) {
      if (rank_of(line.level) < rank_of(options_.level)) continue;
      if (direct_)
        print(line);
      else
        waiting_.push_back(std::move(line));
    }
  }

  void print_waiting() {
    std::stable_sort(waiting_.begin(), waiting_.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
    for (const auto& line : waiting_) print(line);
    waiting_.clear();
    session_.out().flush();
  }

  void print(const LogLine& line) {
    if (session_.json()) {
      return session_.out().line(model::dump(Line{{"island", number(line.island)},
                                                  {"number", line.number},
                                                  {"time", base::iso_text(line.time)},
                                                  {"level", line.level},
                                                  {"subject", line.subject},
                                                  {"text", line.text}}));
    }
    session_.out().line(fmt::format("{} {} {:<7} {}: {}", base::local_text(line.time), number(line.island),
                                    printable(line.level), printable(line.subject), printable(line.text)));
  }

  Session& session_;
  const LogOptions& options_;
  bool heard_ = false;   ///< of at least one island
  bool direct_ = false;  ///< lines are printed as they come
  NewLines new_lines_;
  std::vector<LogLine> waiting_;
};

}  // namespace

void add_log(Cli& cli) {
  const auto options = std::make_shared<LogOptions>();
  auto* app = cli.command_in_ecology({"log", "Show the last lines of the logs of islands",
                                      "  rubicon log\n"
                                      "  rubicon log --follow --level warning\n"
                                      "  rubicon log --island 6541 --json\n"},
                                     [options](Session& session) {
                                       return with_island(session, options->island,
                                                          [&] { return LogReader(session, *options).run(); });
                                     });
  app->add_flag("-f,--follow", options->follow, "go on with new lines as they come");
  app->add_option("--level", options->level, "this level and higher: debug, info (the default), warning, error")
      ->check(CLI::IsMember(std::vector<std::string>(kLevels.begin(), kLevels.end())));
  add_duration_option(app, "--for", options->length, "with --follow: end after this time");
  options->island.add_to(app);
}

}  // namespace rubicon::cli
