#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "apps/rubicon/targets/suggestions.h"
#include "base/compare_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

using client::Point;

/// The values of all points.
std::string usual_pattern(const Settings& settings) {
  return model::IslandKey{settings.prefix}.network("*").device("*").point("*", "*").value();
}

/// A pattern may leave out the lines that its points stand on.
std::vector<client::Tuple> with_lines(Session& session, const std::optional<OwnerId>& owner,
                                      std::vector<client::Tuple> tuples) {
  if (std::any_of(tuples.begin(), tuples.end(), [](const auto& tuple) { return is_value_of_point(tuple.key); })) {
    auto lines = session.read({owner, model::IslandKey{"*"}.network("*").status()});
    std::move(lines.begin(), lines.end(), std::back_inserter(tuples));
  }
  return tuples;
}

/// What fits, points with what belongs to them.
std::vector<Point> all_that_fit(Session& session, const Selections& selections) {
  std::vector<Point> found;
  for (const auto& selection : selections) {
    const auto& pattern = selection.pattern;
    const auto is_meant = [&](const Point& point) { return selection.fits(point.tuple.owner, point.tuple.key); };
    if (const auto points = points_of(pattern)) {
      if (!pattern.owner) session.discover();
      if (auto some = session.client().read_points(*points, session.settings().patience))
        std::copy_if(some->begin(), some->end(), std::back_inserter(found), is_meant);
      continue;
    }
    const auto tuples = session.read(pattern);
    auto points = client::points_from(with_lines(session, pattern.owner, tuples));
    std::copy_if(points.begin(), points.end(), std::back_inserter(found), is_meant);
    for (const auto& tuple : tuples) {
      if (!points_of({tuple.owner, tuple.key}) && selection.fits(tuple.owner, tuple.key))
        found.emplace_back().tuple = tuple;
    }
  }
  std::sort(found.begin(), found.end(), [](const Point& a, const Point& b) {
    if (a.tuple.owner != b.tuple.owner) return a.tuple.owner < b.tuple.owner;
    return base::natural_less(a.tuple.key, b.tuple.key);
  });
  return found;
}

struct LsOptions {
  IslandOption island;
  std::string pattern;
};

int list(Session& session, LsOptions options) {
  if (options.pattern.empty()) options.pattern = usual_pattern(session.settings());
  if (const int code = options.island.put_before(session, options.pattern); code != kGood) return code;
  const auto& text = options.pattern;
  Selections selections;
  if (const int code = selections_called(session, {text}, "value", selections); code != kGood) return code;
  const auto found = all_that_fit(session, selections);
  if (found.empty()) {
    const bool exact = selections.front().pattern.exact();
    return session.not_found(fmt::format("no tuple matches {}", selections.back().text),
                             exact ? suggest_tuple(session, text, "value") : std::string());
  }
  Table table({{"TUPLE", Column::Kind::kKey},
               {"VALUE", Column::Kind::kValue},
               {"QUALITY", Column::Kind::kWord, 1},
               {"AGE", Column::Kind::kWord, 2}});
  for (const auto& point : found) {
    if (session.json()) session.out().line(model::dump(point_json(point)));
    const auto& tuple = point.tuple;
    const auto& quality = point.status.quality;
    table.row({name_of(tuple.owner, tuple.key), tuple.value, tuple.owner_present ? quality : "absent",
               age_text(quality.empty() ? tuple.write_time : point.status.heard, session.now())});
  }
  if (!session.json()) session.out().write(table.text(session.look()));
  return kGood;
}

}  // namespace

void add_ls(Cli& cli) {
  const auto options = std::make_shared<LsOptions>();
  auto* app = cli.command_in_ecology({"ls", "List the tuples that match a pattern, with their values",
                                      "  rubicon ls                                   # the values of all points\n"
                                      "  rubicon ls 'proxy.*.*.status'                # devices\n"
                                      "  rubicon ls 'Living room.*'                   # the values of one device\n"
                                      "  rubicon ls '6541:**' --json                  # everything of one island\n"},
                                     [options](Session& session) { return list(session, *options); });
  app->add_option("PATTERN", options->pattern,
                  "a key with * for one part or within one, a last ** for the rest, or DEVICE.POINT by key or name");
  options->island.add_to(app);
}

}  // namespace rubicon::cli
