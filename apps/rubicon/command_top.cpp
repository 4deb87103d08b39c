#include <fmt/format.h>

#include <set>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_option.h"
#include "apps/rubicon/rates.h"
#include "apps/rubicon/selection.h"
#include "apps/rubicon/tuple_text.h"
#include "base/local_time.h"
#include "model/json_members.h"

namespace rubicon::cli {

namespace {

constexpr Duration kShortest = std::chrono::milliseconds(100);
/// Rows of a round that is not on a terminal.
constexpr std::size_t kRows = 20;

struct TopOptions {
  std::vector<std::string> patterns;
  std::string by = "tuple", interval, length;
  std::size_t rounds = 0;
};

class Top {
 public:
  Top(Session& session, const TopOptions& options) : session_(session), options_(options) {
    interval_ = std::max(kShortest, parse_duration_or(options.interval, std::chrono::seconds(2)));
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
    rates_.count(group_of(name_of(tuple.owner, tuple.key), options_.by), session_.now());
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
                 {"WHAT", Column::Kind::kKey}});
    constexpr std::size_t kHeads = 4;  // lines above the rows, and the one of the cursor
    const auto height = session_.out().height();
    const auto room = height > kHeads ? height - kHeads : kRows;
    for (std::size_t i = 0; i < rows.size() && i < room; ++i)
      table.row({fmt::format("{:.1f}", rows[i].per_second), std::to_string(rows[i].total),
                 age_text(rows[i].last, session_.now()), rows[i].name});
    const auto head =
        fmt::format("{}   {:.1f} events/s of {}, {}", clock_text(session_.now()), sum,
                    counted(rows.size(), options_.by), counted(session_.client().islands().size(), "island"));
    const auto text = head + "\n" + table.text(session_.look());
    session_.out().write(session_.out().is_terminal() ? "\x1b[H\x1b[J" + text : text + "\n");
  }

  void show_lines(const std::vector<Rates::Row>& rows) {
    for (const auto& row : rows) {
      session_.out().line(model::dump({{"time", base::iso_text(session_.now())},
                                       {options_.by, row.name},
                                       {"per_second", row.per_second},
                                       {"total", row.total},
                                       {"last", base::to_seconds(row.last)}}));
    }
  }

  Session& session_;
  const TopOptions& options_;
  Duration interval_{};
  Rates rates_;
  std::set<std::pair<std::size_t, OwnerId>> snapshot_ended_;
  std::chrono::steady_clock::time_point round_began_;
  Handle timer_;
  std::size_t done_ = 0;
};

int top(Session& session, const TopOptions& options) {
  const auto selections =
      parse_selections(with_island_ids(session, options.patterns), session.settings().prefix + ".**", "value");
  if (!selections) {
    print_error(selections.error().text);
    return kUsage;
  }
  return Top(session, options).run(*selections);
}

}  // namespace

void add_top(Cli& cli) {
  const auto options = std::make_shared<TopOptions>();
  auto* app = cli.command_in_ecology({"top", "Show how often tuples are set; wakes no sensors",
                                      "  rubicon top\n"
                                      "  rubicon top --by device 'proxy.*.*.sensor.**'\n"
                                      "  rubicon top --rounds 1 --interval 10s --json\n"},
                                     [options](Session& session) { return top(session, *options); });
  app->add_option("PATTERN", options->patterns, "tuples to count; default: all");
  app->add_option("--by", options->by, "unit of counting: tuple, device, network or island")
      ->check(CLI::IsMember({"tuple", "device", "network", "island"}));
  add_duration_option(app, "--interval", options->interval, "length of a round; default 2s");
  app->add_option("--rounds", options->rounds, "end after so many rounds")->type_name("N")->check(CLI::PositiveNumber);
  add_duration_option(app, "--for", options->length, "end after this time");
}

}  // namespace rubicon::cli
