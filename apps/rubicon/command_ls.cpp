#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/target.h"
#include "apps/rubicon/tuple_text.h"

namespace rubicon::cli {

namespace {

using client::Tuple;

/// The values of all points.
std::string usual_pattern(const Settings& settings) {
  return settings.prefix + ".*.*.*.*.value";
}

/// Patterns of values find no statuses: the pattern of those beside them.
std::optional<Pattern> beside(const Pattern& pattern) {
  if (last_part(pattern.key) != "value") return std::nullopt;
  return Pattern{pattern.owner, without_last_part(pattern.key) + ".status"};
}

Line with_quality(Line line, const PointState* state) {
  if (!state || state->quality.empty()) return line;
  line["quality"] = state->quality;
  line["heard"] = base::to_seconds(state->heard);
  return line;
}

int list(Session& session, const std::string& text) {
  const auto patterns = parse_patterns(text.empty() ? usual_pattern(session.settings()) : text, "value");
  if (!patterns) {
    say(patterns.error().text);
    return kUsage;
  }
  std::vector<Tuple> found, statuses;
  for (const auto& pattern : *patterns) {
    for (auto& tuple : session.read(pattern)) found.push_back(std::move(tuple));
    if (const auto other = beside(pattern); other && !found.empty()) statuses = session.read(*other);
  }
  std::sort(found.begin(), found.end(),
            [](const Tuple& a, const Tuple& b) { return std::tie(a.owner, a.key) < std::tie(b.owner, b.key); });
  const auto states = states_of(statuses.empty() ? found : statuses);
  Table table({"TUPLE", "VALUE", "QUALITY", "AGE"});
  for (const auto& tuple : found) {
    const auto state =
        last_part(tuple.key) == "value" ? states.find({tuple.owner, without_last_part(tuple.key)}) : states.end();
    const auto* known = state == states.end() ? nullptr : &state->second;
    if (session.json()) {
      session.out().line(dump(with_quality(tuple_json(tuple), known)));
      continue;
    }
    const auto quality = !tuple.owner_present ? std::string("absent") : known ? known->quality : std::string();
    table.row({name_of(tuple.owner, tuple.key), tuple.value, quality,
               age_text(known ? known->heard : tuple.write_time, session.now())});
  }
  if (found.empty()) return session.nothing(fmt::format("no tuple fits {}", to_string(patterns->back())));
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

}  // namespace

void add_ls(Cli& cli) {
  const auto pattern = std::make_shared<std::string>();
  auto* app = cli.command_in_ecology({"ls", "List the tuples that fit a pattern, with their values",
                                      "  rubicon ls                                   # the values of all points\n"
                                      "  rubicon ls 'proxy.*.*.status'                # devices\n"
                                      "  rubicon ls '6541:**' --json                  # everything of one island\n"},
                                     [pattern](Session& session) { return list(session, *pattern); });
  app->add_option("PATTERN", *pattern, "a key with * for one part and a last ** for the rest; ISLAND: in front");
}

}  // namespace rubicon::cli
