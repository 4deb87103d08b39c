#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/target.h"
#include "apps/rubicon/tuple_text.h"
#include "apps/rubicon/woken.h"
#include "runtime/event_json.h"

namespace rubicon::cli {

namespace {

struct WatchOptions {
  std::vector<std::string> patterns;
  bool changes = false, passive = false;
  std::string minimum, maximum, length;
  double dead_band = 0;
  std::size_t count = 0;
};

/// Shows events as they come.
class Watch {
 public:
  Watch(Session& session, const WatchOptions& options, std::vector<Pattern> patterns)
      : session_(session), options_(options), patterns_(std::move(patterns)), start_(session.now()) {}

  int run() {
    const Flow flow{span_of(options_.minimum), span_of(options_.maximum), options_.dead_band, options_.passive};
    std::vector<Handle> subscriptions;
    for (const auto& pattern : patterns_) {
      subscriptions.push_back(
          session_.client().tuples().subscribe(pattern, flow, [this](const Event& event) { take(event); }));
    }
    if (!options_.passive) tell_who_wakes(session_.client(), patterns_);
    const auto silence = session_.client().after(session_.settings().patience, [this] { explain_silence(); });
    session_.run([this] { return options_.count > 0 && shown_ >= options_.count; },
                 span_of(options_.length, Duration::max()));
    if (session_.interrupted()) sum_up();
    return shown_ == 0 && !session_.interrupted() ? kNotThere : kGood;
  }

 private:
  void take(const Event& event) {
    if (options_.count > 0 && shown_ >= options_.count) return;
    const std::pair name(event.tuple.owner, std::string(event.tuple.key));
    if (event.kind == EventKind::kSet) {
      const auto value = std::hash<std::string_view>{}(event.tuple.value);
      const auto [known, fresh] = values_.try_emplace(name, value);
      if (options_.changes && !fresh && known->second == value) return;
      known->second = value;
    } else {
      values_.erase(name);
    }
    ++shown_;
    session_.out().line(session_.json() ? runtime::event_line(event) : text_of(event));
  }

  std::string text_of(const Event& event) const {
    const auto& tuple = event.tuple;
    const auto time = clock_text(tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time);
    const auto name = name_of(tuple.owner, tuple.key);
    const auto text = event.kind == EventKind::kSet
                          ? fmt::format("{}  {} = {}", time, name, clean(tuple.value))
                          : fmt::format("{}  {} {}", clock_text(session_.now()), name, to_string(event.kind));
    return cut(text, session_.look().width);
  }

  void explain_silence() {
    if (shown_ > 0) return;
    std::ignore = session_.nothing(fmt::format("nothing fits {} yet", to_string(patterns_.back())));
  }

  void sum_up() {
    session_.out().flush();
    say(fmt::format("{} of {} in {}", counted(shown_, "event"), counted(values_.size(), "tuple"),
                    age_text(start_, session_.now())));
  }

  Session& session_;
  const WatchOptions& options_;
  std::vector<Pattern> patterns_;
  WallTime start_;
  std::size_t shown_ = 0;
  std::map<std::pair<OwnerId, std::string>, std::size_t> values_;  ///< hashes of the last ones
};

int watch(Session& session, const WatchOptions& options) {
  auto patterns = parse_patterns(options.patterns, session.settings().prefix + ".*.*.*.*.value", "value");
  if (!patterns) {
    say(patterns.error().text);
    return kUsage;
  }
  return Watch(session, options, std::move(*patterns)).run();
}

}  // namespace

void add_watch(Cli& cli) {
  const auto options = std::make_shared<WatchOptions>();
  auto* app =
      cli.command_in_ecology({"watch", "Show what happens to tuples, line by line; sensors that are watched measure",
                              "  rubicon watch                                  # the values of all points\n"
                              "  rubicon watch living.illuminance-1 --min-interval 1s\n"
                              "  rubicon watch 'proxy.*.*.status' --passive --json\n"
                              "  rubicon watch 'proxy.*.*.sensor.contact-*.value' --changes --for 1h\n"
                              "A subscription wakes the sensors it fits; --passive only looks at what others wake.\n"},
                             [options](Session& session) { return watch(session, *options); });
  app->add_option("PATTERN", options->patterns, "which tuples, also DEVICE.POINT; the values of all points if none");
  app->add_flag("--changes", options->changes, "only values that differ from the one before");
  app->add_flag("--passive", options->passive, "wake no sensors");
  add_span(app, "--min-interval", options->minimum, "at most one event of a tuple in this time");
  add_span(app, "--max-interval", options->maximum, "the value again if nothing came for so long");
  app->add_option("--dead-band", options->dead_band, "hold back changes smaller than this")
      ->check(CLI::NonNegativeNumber);
  add_span(app, "--for", options->length, "end after this time");
  app->add_option("--count", options->count, "end after so many lines")->type_name("N")->check(CLI::PositiveNumber);
}

}  // namespace rubicon::cli
