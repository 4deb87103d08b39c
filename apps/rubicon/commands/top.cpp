#include <fmt/format.h>

#include <set>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/doctor/signs.h"
#include "apps/rubicon/live/screen.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "base/clocks.h"
#include "model/json_members.h"

namespace rubicon::cli {

namespace {

constexpr Duration kMinTime = std::chrono::milliseconds(100);
/// Of a round.
constexpr std::size_t kRows = 20;

struct TopOptions {
  std::vector<std::string> patterns;
  std::string by, interval, length;
  std::size_t rounds = 0;
  IslandOption island;
  bool is_passive = false, has_rates = false;

  bool wants_rates() const { return has_rates || !patterns.empty() || !by.empty() || !interval.empty() || rounds > 0; }
};

/// Prints rates, round by round.
class Top {
 public:
  Top(Session& session, const TopOptions& options)
      : session_(session), options_(options), by_(options.by.empty() ? "tuple" : options.by) {
    interval_ = std::max(kMinTime, parse_duration_or(options.interval, std::chrono::seconds(2)));
    names_ = known_names(session);
  }

  int run(const Selections& selections) {
    auto& space = session_.client().tuples();
    std::vector<Handle> subscriptions;
    std::size_t number = 0;
    for (const auto& selection : selections) {
      const auto one = number++;
      subscriptions.push_back(space.subscribe(
          selection.pattern, {.passive = true},
          [this, one, &selection](const Event& event) {
            if (selection.fits(event.tuple.owner, event.tuple.key)) take(one, event);
          },
          [this, one](OwnerId owner) { snapshot_ended_.emplace(one, owner); }));
    }
    session_.discover();
    begin_round();
    session_.run([this] { return options_.rounds > 0 && done_ >= options_.rounds; },
                 parse_duration_or(options_.length, Duration::max()));
    return kGood;
  }

 private:
  /// What was there before is not news.
  void take(std::size_t pattern, const Event& event) {
    const auto& tuple = event.tuple;
    if (!snapshot_ended_.contains({pattern, tuple.owner})) return;
    rates_.count(group_of(name_of(tuple.owner, tuple.key), by_), session_.now());
  }

  void begin_round() {
    round_began_ = std::chrono::steady_clock::now();
    timer_ = session_.client().after(interval_, [this] {
      show(std::chrono::steady_clock::now() - round_began_);
      ++done_;
      begin_round();
    });
  }

  void show(Duration length) {
    const auto rows = rates_.round(length);
    if (session_.json()) return show_lines(rows);
    double sum = 0;
    for (const auto& row : rows) sum += row.per_second;
    Table table({{"PER SECOND"},
                 {"TOTAL", Column::Kind::kWord, 1},
                 {"LAST", Column::Kind::kWord, 2},
                 {"WHAT", Column::Kind::kKey},
                 {"NAME", Column::Kind::kText, 3}});
    for (std::size_t i = 0; i < rows.size() && i < kRows; ++i)
      table.row({fmt::format("{:.1f}", rows[i].per_second), std::to_string(rows[i].total),
                 age_text(rows[i].last, session_.now()), rows[i].name, client::name_of(names_, rows[i].name)});
    const auto head = fmt::format("{}   {:.1f} events/s of {}, {}", clock_text(session_.now()), sum,
                                  counted(rows.size(), by_), counted(session_.client().islands().size(), "island"));
    session_.out().write(head + "\n" + table.text(session_.look()) + "\n");
  }

  void show_lines(const std::vector<Rates::Row>& rows) {
    for (const auto& row : rows) {
      session_.out().line(model::dump({{"time", base::iso_text(session_.now())},
                                       {by_, row.name},
                                       {"name", client::name_of(names_, row.name)},
                                       {"per_second", row.per_second},
                                       {"total", row.total},
                                       {"last", base::to_seconds(row.last)}}));
    }
  }

  Session& session_;
  const TopOptions& options_;
  const std::string by_;
  Duration interval_{};
  client::KnownNames names_;
  Rates rates_;
  std::set<std::pair<std::size_t, OwnerId>> snapshot_ended_;
  std::chrono::steady_clock::time_point round_began_;
  Handle timer_;
  std::size_t done_ = 0;
};

int show_table(Session& session, const TopOptions& options) {
  live::ScreenOptions screen{options.island.owner(), options.is_passive, parse_duration_or(options.length), {}};
  screen.command = [&session](const std::string& line) { std::ignore = Cli().run_line(session, line); };
  return live::show_table(session, screen);
}

int top(Session& session, const TopOptions& options) {
  if (!options.wants_rates() && !session.json() && live::owns_terminal()) return show_table(session, options);
  auto patterns = options.patterns;
  if (patterns.empty())
    patterns.push_back(to_string(Pattern{options.island.owner(), session.settings().prefix + ".**"}));
  Selections selections;
  if (const int code = selections_called(session, patterns, "value", selections); code != kGood) return code;
  return Top(session, options).run(selections);
}

}  // namespace

void add_top(Cli& cli) {
  const auto options = std::make_shared<TopOptions>();
  auto* app = cli.command_in_ecology(
      {"top", "Show values as they come, or how often they come",
       "  rubicon top                                      # on a terminal: a table; ? lists its keys\n"
       "  rubicon top --by device 'proxy.*.*.sensor.**'    # rates\n"
       "  rubicon top --rounds 1 --interval 10s --json\n"
       "On a terminal: a live table of networks, devices and points, in which commands can be typed.\n"
       "It wakes all sensors, unless --passive. Elsewhere, or with options for them: rates, how often\n"
       "tuples are set; they wake no sensors.\n"},
      [options](Session& session) {
        return with_island(session, options->island, [&] { return top(session, *options); });
      });
  app->add_flag("--passive", options->is_passive, "the table wakes no sensors");
  app->add_flag("--rates", options->has_rates, "rates, on a terminal too");
  options->island.add_to(app);
  app->add_option("PATTERN", options->patterns,
                  "tuples to count, for rates, also DEVICE.POINT by key or name; default: all");
  app->add_option("--by", options->by, "unit of counting: tuple, device, network or island")
      ->check(CLI::IsMember({"tuple", "device", "network", "island"}));
  add_duration_option(app, "--interval", options->interval, "length of a round; default 2s");
  app->add_option("--rounds", options->rounds, "end after so many rounds")->type_name("N")->check(CLI::PositiveNumber);
  add_duration_option(app, "--for", options->length, "end after this time");
}

}  // namespace rubicon::cli
