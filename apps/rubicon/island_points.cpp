#include "apps/rubicon/island_points.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"

namespace rubicon::cli {

ChosenIsland choose_island(Session& session, const IslandOption& option, const std::string& key,
                           const std::string& what) {
  std::vector<OwnerId> islands;
  std::vector<std::string> names;
  for (const auto& tuple : session.read({option.owner(), key})) {
    islands.push_back(tuple.owner);
    names.push_back(session.component_text(tuple.owner));
  }
  if (islands.size() == 1) return {islands.front(), kGood};
  if (islands.empty()) return {{}, session.not_found("no " + what)};
  print_error(fmt::format("{} is of the islands {}; choose one with --island", what, fmt::join(names, ", ")));
  return {{}, kUsage};
}

int command_island(Session& session, OwnerId island, const std::string& key, const std::string& text,
                   const std::string& done) {
  const auto outcome = session.client().command(island, key, text);
  if (session.json()) {
    session.out().line(model::dump({{"island", number(island)},
                                    {"key", key},
                                    {"value", text},
                                    {"state", outcome.state},
                                    {"reason", outcome.reason}}));
  } else if (outcome.good()) {
    if (!done.empty()) session.out().line(done);
  } else {
    print_error(fmt::format("{}: {}", outcome.state, printable(outcome.reason)));
  }
  return exit_code_of(outcome.state);
}

}  // namespace rubicon::cli
