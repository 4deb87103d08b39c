#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

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

/// Of a tuple, on a line that is too short for all: its value is never cut.
constexpr std::size_t kMinName = 24;

struct WatchOptions {
  IslandOption island{};
  std::vector<std::string> patterns{};
  bool changes = false, passive = false;
  std::string minimum{}, maximum{}, length{};
  double dead_band = 0;
  std::size_t count = 0;
};

/// Practically unlimited, and still safe to add to the current time.
constexpr Duration kForEver = std::chrono::hours(24 * 365 * 20);

/// Shows events as they come.
class Watch {
 public:
  Watch(Session& session, const WatchOptions& options, Selections selections)
      : session_(session),
        options_(options),
        selections_(std::move(selections)),
        flow_{parse_duration_or(options.minimum), parse_duration_or(options.maximum), options.dead_band,
              options.passive},
        whole_(std::min(parse_duration_or(options.length, kForEver), kForEver)),
        start_(session.now()) {}

  int run() {
    for (const auto& selection : selections_) follow(selection);
    if (!options_.passive) warn_if_many_wake(session_.client(), selections_);
    const auto enough = [this] { return options_.count > 0 && shown_ >= options_.count; };
    const auto end = session_.now() + std::chrono::ceil<std::chrono::microseconds>(whole_);
    session_.run([&] { return shown_ > 0 || enough(); }, std::min(session_.settings().patience, whole_));
    if (shown_ == 0 && !session_.interrupted()) explain_silence();
    if (!enough() && !session_.interrupted() && session_.now() < end) session_.run(enough, end - session_.now());
    if (session_.interrupted()) sum_up();
    if (wakers_.full()) return kFailed;
    return shown_ == 0 && !session_.interrupted() ? kNotThere : kGood;
  }

 private:
  /// A subscription wakes all that its pattern fits: of a narrower selection it is passive, and what fits is woken one
  /// by one, as it is found.
  void follow(const Selection& selection) {
    auto flow = flow_;
    flow.passive = options_.passive || selection.narrower();
    handles_.push_back(followed(selection, flow));
  }

  /// Values of points come with their quality, and again when that changes; all other tuples as they are.
  Handle followed(const Selection& selection, const Flow& flow) {
    if (const auto points = points_of(selection.pattern)) {
      auto watch = session_.client().watch_points(
          *points, flow, [this, selection](PointEvent event, const Point& point) { found(selection, event, point); });
      if (watch) return std::move(*watch);
    }
    return session_.client().tuples().subscribe(selection.pattern, flow, [this, selection](const Event& event) {
      Point plain;
      plain.tuple = client::Tuple(event.tuple);
      const auto what = event.kind == EventKind::kSet ? PointEvent::kValue : PointEvent::kRemoved;
      found(selection, what, plain, to_string(event.kind));
    });
  }

  void found(const Selection& selection, PointEvent event, const Point& point, std::string_view what = {}) {
    const auto& tuple = point.tuple;
    if (!selection.fits(tuple.owner, tuple.key)) return;
    if (selection.narrower() && !options_.passive) {
      event == PointEvent::kRemoved ? wakers_.forget(tuple.owner, tuple.key) : wakers_.wake(tuple.owner, tuple.key);
    }
    take(event, point, what);
  }

  /// The passive subscription shows what this one brings.
  Handle woken(const Pattern& exact) {
    return session_.client().tuples().subscribe(exact, flow_, [](const Event&) {});
  }

  /// `what`: how it went, where that is known.
  void take(PointEvent event, const Point& point, std::string_view what = {}) {
    if (options_.count > 0 && shown_ >= options_.count) return;
    const std::pair name(point.tuple.owner, point.tuple.key);
    if (event == PointEvent::kRemoved) {
      values_.erase(name);
    } else {
      const auto value = std::hash<std::string_view>{}(point.value() + '\n' + point.status.quality);
      const auto [known, fresh] = values_.try_emplace(name, value);
      const bool news = fresh || known->second != value || event == PointEvent::kState || point.is_event;
      if (options_.changes && !news) return;
      known->second = value;
    }
    ++shown_;
    if (event == PointEvent::kRemoved && what.empty()) what = point.tuple.owner_present ? "deleted" : "lost";
    if (event == PointEvent::kValue) what = "set";
    if (event == PointEvent::kState) what = "quality";
    session_.out().line(session_.json() ? json_of(point, what) : text_of(event, point, what));
  }

  static std::string json_of(const Point& point, std::string_view what) {
    auto line = point_json(point);
    line["event"] = what;
    return model::dump(line);
  }

  static std::string value_text(const Point& point) {
    return point.is_event && point.value().empty() ? "(no event now)" : printable(point.value());
  }

  std::string text_of(PointEvent event, const Point& point, std::string_view what) const {
    const auto& tuple = point.tuple;
    const auto measured = tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time;
    const auto time = clock_text(event == PointEvent::kValue ? measured : session_.now());
    const bool has_news = event == PointEvent::kState || (!point.status.quality.empty() && !point.good());
    const auto quality = has_news ? "  " + printable(quality_text(point)) : std::string();
    const auto rest =
        event == PointEvent::kRemoved ? fmt::format(" {}", what) : fmt::format(" = {}{}", value_text(point), quality);
    auto name = name_of(tuple.owner, tuple.key);
    const auto used = characters(time) + 2 + characters(rest);
    const auto width = session_.look().width;
    if (width > 0) name = shortened(name, std::max(kMinName, width - std::min(width, used)));
    return fmt::format("{}  {}{}", time, name, rest);
  }

  void explain_silence() {
    const auto& typed = options_.patterns.back();
    const bool exact = selections_.front().pattern.exact();
    std::ignore = session_.not_found(fmt::format("nothing fits {} yet", printable(typed)),
                                     exact ? suggest_tuple(session_, typed, "value") : std::string());
  }

  void sum_up() {
    session_.out().flush();
    print_error(fmt::format("{} of {} in {}", counted(shown_, "event"), counted(values_.size(), "tuple"),
                            age_text(start_, session_.now())));
  }

  Session& session_;
  const WatchOptions& options_;
  const Selections selections_;
  const Flow flow_;
  const Duration whole_;
  WallTime start_;
  std::size_t shown_ = 0;
  std::map<std::pair<OwnerId, std::string>, std::size_t> values_;  ///< hashes of the last ones
  std::vector<Handle> handles_;
  Wakers wakers_{[this](const Pattern& exact) { return woken(exact); }};
};

int watch(Session& session, WatchOptions options) {
  auto usual = model::IslandKey{session.settings().prefix}.network("*").device("*").point("*", "*").value();
  if (options.patterns.empty()) options.patterns.push_back(std::move(usual));
  if (const int code = options.island.put_before(session, options.patterns); code != kGood) return code;
  Selections selections;
  if (const int code = selections_called(session, options.patterns, "value", selections); code != kGood) return code;
  return Watch(session, options, std::move(selections)).run();
}

}  // namespace

void add_watch(Cli& cli) {
  const auto options = std::make_shared<WatchOptions>();
  auto* app = cli.command_in_ecology(
      {"watch", "Print changes of tuples, one per line; wakes the sensors that match",
       "  rubicon watch                                  # the values of all points\n"
       "  rubicon watch living.light-1 --min-interval 1s\n"
       "  rubicon watch 'Living room.*'                  # by the name of the device\n"
       "  rubicon watch 'proxy.*.*.status' --passive --json\n"
       "  rubicon watch 'proxy.*.*.sensor.contact-*.value' --changes --for 1h\n"
       "The quality follows a value that is not good; a change of quality has a line of its own.\n"
       "A subscription wakes the sensors that match; --passive shows only what others wake.\n"
       "With a * within a part it wakes at most 9000, warns beyond that, and ends with 1.\n"},
      [options](Session& session) { return watch(session, *options); });
  app->add_option("PATTERN", options->patterns,
                  "tuples to watch, also DEVICE.POINT by key or name; default: the values of all points");
  options->island.add_to(app);
  app->add_flag("--changes", options->changes, "only values that differ from the previous one");
  app->add_flag("--passive", options->passive, "wake no sensors");
  add_duration_option(app, "--min-interval", options->minimum, "at most one event of a tuple in this time");
  add_duration_option(app, "--max-interval", options->maximum, "repeat the value after this time without a change");
  app->add_option("--dead-band", options->dead_band, "hold back changes smaller than this")
      ->check(CLI::NonNegativeNumber);
  add_duration_option(app, "--for", options->length, "end after this time");
  app->add_option("--count", options->count, "end after so many lines")->type_name("N")->check(CLI::PositiveNumber);
}

}  // namespace rubicon::cli
