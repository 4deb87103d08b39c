#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "base/compare_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

struct InboxOptions {
  IslandOption island;
  std::string which;
};

int list(Session& session, const InboxOptions& options) {
  const model::IslandKey island{session.settings().prefix};
  using Kind = Column::Kind;
  Table table({{"ISLAND"},
               {"DEVICE", Kind::kKey},
               {"NAME", Kind::kText, 1},
               {"MODEL", Kind::kText, 3},
               {"ADDRESS", Kind::kText, 2},
               {"SINCE", Kind::kWord, 4},
               {"WHY", Kind::kText}});
  for (const auto& tuple : session.read({options.island.owner(), island.inbox("*.*")})) {
    const auto about = model::object_of(tuple.value);
    if (session.json()) {
      auto line = about;
      line["island"] = number(tuple.owner);
      session.out().line(model::dump(line));
    }
    table.row({session.component_text(tuple.owner), model::text_of(about, "key"), model::text_of(about, "name"),
               model::text_of(about, "model"), model::text_of(about, "address"),
               age_text(model::time_of(about, "since"), session.now()), model::text_of(about, "why")});
  }
  if (session.json()) return kGood;
  if (!table.empty()) session.out().write(table.text(session.look()));
  std::size_t ignored = 0;
  const auto inboxes = session.read({options.island.owner(), island.inbox()});
  for (const auto& tuple : inboxes)
    ignored += static_cast<std::size_t>(std::max(0.0, model::number_of(model::object_of(tuple.value), "ignored")));
  if (inboxes.empty()) return session.not_found("no inbox");
  if (table.empty()) session.out().line("no device waits");
  if (ignored > 0) session.out().line(fmt::format("{} ignored", counted(ignored, "device")));
  return kGood;
}

/// Islands whose inbox has this entry (or, for the key of an inbox: that have one).
std::set<OwnerId> islands_for(Session& session, const InboxOptions& options, const std::string& key) {
  std::set<OwnerId> islands;
  for (const auto& tuple : session.read({options.island.owner(), key})) islands.insert(tuple.owner);
  return islands;
}

/// Islands with a waiting device that a word with * or ? fits.
std::set<OwnerId> islands_that_fit(Session& session, const InboxOptions& options) {
  std::set<OwnerId> islands;
  const model::IslandKey island{session.settings().prefix};
  for (const auto& tuple : session.read({options.island.owner(), island.inbox("*.*")})) {
    const auto about = model::object_of(tuple.value);
    if (base::glob_matches(options.which, model::text_of(about, "key"))) islands.insert(tuple.owner);
  }
  return islands;
}

std::string_view done_text(std::string_view word) {
  return word == "approve" ? "approved" : word == "ignore" ? "ignored" : "forgot";
}

/// The listed device that a word without * and ? names, also as people do; kGood with `islands` empty: there is none.
int find_listed(Session& session, InboxOptions& options, std::set<OwnerId>& islands) {
  auto found = client::devices_called(known_names(session), options.which);
  const auto wanted = options.island.owner();
  if (wanted) std::erase_if(found, [&](const auto& one) { return one.island != *wanted; });
  if (found.size() > 1) return ambiguous(options.which, found);
  if (found.empty()) return kGood;
  islands.insert(found.front().island);
  options.which = found.front().network + "." + found.front().id;
  return kGood;
}

/// `wsn-1.7` is one device, a word with * or ? all that wait and fit; what does not wait is asked of the inbox itself.
int decide(Session& session, InboxOptions options, const std::string& word) {
  const model::IslandKey island{session.settings().prefix};
  const auto inbox = island.inbox();
  const auto one = island.inbox(options.which);
  const bool single = model::check_key(one).has_value();
  auto islands = single ? islands_for(session, options, one) : std::set<OwnerId>();
  const bool waits = !islands.empty();
  const bool is_pattern = options.which.find_first_of("*?") != std::string::npos;
  if (is_pattern) islands = islands_that_fit(session, options);
  if (islands.empty() && !is_pattern && word != "approve") {
    if (const int code = find_listed(session, options, islands); code != kGood) return code;
  }
  if (islands.empty()) islands = islands_for(session, options, inbox);
  if (islands.empty()) return session.not_found("no inbox");
  if (islands.size() > 1) {
    std::vector<std::string> names;
    for (const auto id : islands) names.push_back(session.component_text(id));
    print_error(fmt::format("{} may be of island {}; choose one with --island", model::quoted(options.which),
                            fmt::join(names, " or ")));
    return kUsage;
  }
  const auto outcome = waits ? session.command(*islands.begin(), one, word)
                             : session.command(*islands.begin(), inbox, word + " " + options.which);
  if (session.json()) {
    session.out().line(model::dump({{"island", number(*islands.begin())},
                                    {"decision", word},
                                    {"device", options.which},
                                    {"state", outcome.state},
                                    {"reason", outcome.reason}}));
  } else if (outcome.good()) {
    session.out().line(fmt::format("{} {}{}{}", done_text(word), printable(options.which),
                                   outcome.reason.empty() ? "" : "; ", printable(outcome.reason)));
  } else {
    print_error(fmt::format("{} {}: {}", outcome.state, model::quoted(options.which), printable(outcome.reason)));
  }
  return exit_code_of(outcome.state);
}

}  // namespace

void add_inbox(Cli& cli) {
  const auto options = std::make_shared<InboxOptions>();
  const auto action = std::make_shared<std::string>("list");
  auto* app = cli.command_in_ecology(
      {"inbox", "List devices that wait for a decision; approve, ignore or forget devices",
       "  rubicon inbox\n"
       "  rubicon inbox approve dummy-new.guest\n"
       "  rubicon inbox ignore 'dummy-new.*' --island 6541     # all that match\n"
       "  rubicon inbox forget 'Old mote'              # also a listed one: its names and values go, too\n"},
      [options, action](Session& session) {
        if (*action != "list" && options->which.empty()) {
          print_error(fmt::format("{}: no device given; expected NETWORK.DEVICE", *action));
          return static_cast<int>(kUsage);
        }
        return with_network(session, options->island, options->which, [&] {
          return *action == "list" ? list(session, *options) : decide(session, *options, *action);
        });
      });
  app->add_option("ACTION", *action, "list, approve, ignore or forget")
      ->check(CLI::IsMember({"list", "approve", "ignore", "forget"}));
  app->add_option("DEVICE", options->which, "NETWORK.DEVICE, also with * and ?; of a listed device also its name");
  options->island.add_to(app);
}

}  // namespace rubicon::cli
