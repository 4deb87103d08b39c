#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "apps/rubicon/targets/suggestions.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

using client::Point;
using client::PointEvent;
using client::Tuple;

struct GetOptions {
  IslandOption island{};
  std::vector<std::string> targets{};
  bool all = false, fresh = false, any_quality = false, quiet = false;
};

/// Everything about a tuple, line by line.
class Sheet {
 public:
  Sheet(WallTime now, bool colour) : now_(now), colour_(colour) {}

  void put(const char* name, const std::string& text) {
    out_ += fmt::format("{} {}\n", bold(fmt::format("{:<10}", name), colour_), printable(text));
  }
  void put(const char* name, WallTime time) {
    put(name,
        time == WallTime{} ? std::string("-") : fmt::format("{} ({} ago)", time_text(time), age_text(time, now_)));
  }
  const std::string& text() const { return out_; }

 private:
  WallTime now_;
  bool colour_;
  std::string out_;
};

std::string all_text(const Point& point, const std::string& creator, WallTime now, bool colour) {
  const auto& tuple = point.tuple;
  Sheet sheet(now, colour);
  sheet.put("tuple", name_of(tuple.owner, tuple.key));
  sheet.put("value", tuple.value);
  if (const auto quality = quality_text(point); !quality.empty()) {
    sheet.put("quality", quality);
    sheet.put("heard", point.status.heard);
    sheet.put("changed", point.status.changed);
    sheet.put("line", line_text(point.line));
  }
  sheet.put("media type", tuple.media_type);
  sheet.put("seq", std::to_string(tuple.sequence));
  sheet.put("creator", creator);
  sheet.put("written", tuple.write_time);
  sheet.put("measured", tuple.user_time);
  sheet.put("expires", tuple.expire_time == WallTime{} ? "never" : time_text(tuple.expire_time));
  if (!tuple.owner_present) sheet.put("owner", "absent");
  return sheet.text();
}

/// A tuple that is not a point has no quality.
Point plain(Tuple tuple) {
  Point point;
  point.tuple = std::move(tuple);
  return point;
}

std::optional<Point> read_one(Session& session, const Target& target) {
  if (is_value_of_point(target.key)) {
    auto found = session.client().read_points({target.owner, std::string(model::parent_key(target.key))},
                                              session.settings().patience);
    return found && !found->empty() ? std::optional(std::move(found->front())) : std::nullopt;
  }
  auto found = session.read({target.owner, target.key});
  return found.empty() ? std::nullopt : std::optional(plain(std::move(found[0])));
}

/// Wakes the sensor and takes the first value that is newer than what was there.
std::optional<Point> fresh_value(Session& session, const Target& target, const Tuple& old) {
  std::optional<Point> found;
  const auto take = [&](const Point& point) {
    const auto& tuple = point.tuple;
    const bool newer = tuple.sequence != old.sequence || tuple.write_time != old.write_time;
    if (newer && !tuple.value.empty()) found = point;
  };
  Handle handle;
  if (is_value_of_point(target.key)) {
    auto watch = session.client().watch_points({target.owner, std::string(model::parent_key(target.key))}, {},
                                               [&](PointEvent event, const Point& point) {
                                                 if (event == PointEvent::kValue) take(point);
                                               });
    if (watch) handle = std::move(*watch);
  } else {
    handle = session.client().tuples().subscribe({target.owner, target.key}, {}, [&](const Event& event) {
      if (event.kind == EventKind::kSet) take(plain(Tuple(event.tuple)));
    });
  }
  session.run([&] { return found.has_value(); }, session.settings().patience);
  return found;
}

void show(Session& session, const Point& point, const GetOptions& options) {
  auto& out = session.out();
  const auto& tuple = point.tuple;
  if (session.json()) return out.line(model::dump(point_json(point)));
  if (options.all)
    return out.write(all_text(point, session.component_text(tuple.creator), session.now(), out.has_colour()));
  const auto value = out.is_terminal() ? printable(tuple.value) : tuple.value;
  const bool named = options.targets.size() > 1;
  out.line(named ? fmt::format("{} {}", name_of(tuple.owner, tuple.key), value) : value);
}

/// Prints quality and reason of a value that is not good.
int report_quality(Session& session, const Point& point, const GetOptions& options) {
  if (point.status.quality.empty() || point.good()) return kGood;
  if (!options.quiet) {
    session.out().flush();
    const auto last = point.status.heard == WallTime{} ? "never" : age_text(point.status.heard, session.now()) + " ago";
    const bool can_be_asked =
        point.value().empty() && !point.is_event && point.key().find(".sensor.") != std::string::npos;
    const auto name = name_of(point.tuple.owner, point.key());
    print_error(printable(point.is_event && point.status.quality == "good"
                              ? fmt::format("{} is an event, and none is there now; the last one came {}", name, last)
                              : fmt::format("{} is {}; last heard {}{}", name, quality_text(point), last,
                                            can_be_asked ? "; --fresh asks the device" : "")));
  }
  return options.any_quality ? kGood : kNotGood;
}

int get_one(Session& session, const std::string& text, const GetOptions& options) {
  const auto candidates = targets_called(session, text, "value");
  if (!candidates) {
    print_error(candidates.error().text);
    return kUsage;
  }
  if (candidates->empty())
    return session.not_found(fmt::format("no tuple {}", printable(text)), suggest_tuple(session, text, "value"));
  if (candidates->size() > 1) return ambiguous(text, *candidates);
  const auto& target = candidates->front();
  auto found = read_one(session, target);
  if (!found) return session.not_found(fmt::format("tuple {} is gone", printable(text)));
  if (options.fresh) {
    auto newer = fresh_value(session, target, found->tuple);
    if (!newer) {
      print_error(fmt::format("{} got no new value in time{}{}", name_of(target.owner, target.key),
                              found->status.quality.empty() ? "" : ": it is ", printable(quality_text(*found))));
      return kTimedOut;
    }
    found = std::move(newer);
  }
  show(session, *found, options);
  return report_quality(session, *found, options);
}

int get(Session& session, GetOptions options) {
  if (const int code = options.island.put_before(session, options.targets); code != kGood) return code;
  int code = kGood;
  for (const auto& text : options.targets) {
    if (const int one = get_one(session, text, options); code == kGood) code = one;
  }
  return code;
}

}  // namespace

void add_get(Cli& cli) {
  const auto options = std::make_shared<GetOptions>();
  auto* app = cli.command_in_ecology(
      {"get", "Show the value of a tuple",
       "  rubicon get living.light-1\n"
       "  rubicon get 'Living room.light'              # by the name of the device, and the type\n"
       "  rubicon get --fresh living.light-1           # ask the sensor and wait for its answer\n"
       "  rubicon get --any-quality --quiet living.lamp-1 # the value, whatever its quality\n"
       "  rubicon get --all 6541:proxy.networks        # creator, times, media type, sequence number\n"
       "The value goes to standard output. If its quality is not good, quality and reason go to standard error,\n"
       "and the exit code is 10.\n"},
      [options](Session& session) { return get(session, *options); });
  app->add_option("TUPLE", options->targets,
                  "key, or DEVICE.POINT by key or name; with ISLAND: in front where several have it")
      ->required();
  options->island.add_to(app);
  app->add_flag("--all", options->all, "all properties of the tuple");
  app->add_flag("--fresh", options->fresh, "wake the sensor by a subscription, and wait for its next value");
  app->add_flag("--any-quality", options->any_quality, "exit code 0 for every quality");
  app->add_flag("--quiet", options->quiet, "do not print the quality on standard error");
}

}  // namespace rubicon::cli
