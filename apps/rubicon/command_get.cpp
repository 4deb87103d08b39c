#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/target.h"
#include "apps/rubicon/tuple_text.h"

namespace rubicon::cli {

namespace {

using client::Tuple;

struct GetOptions {
  std::vector<std::string> targets;
  bool all = false, fresh = false;
};

std::string all_text(const Tuple& tuple, WallTime now, bool colour) {
  const auto when = [now](WallTime time) {
    return time == WallTime{} ? std::string("-") : fmt::format("{} ({} ago)", time_text(time), age_text(time, now));
  };
  std::string out;
  const auto put = [&](const char* name, const std::string& text) {
    out += fmt::format("{} {}\n", bold(fmt::format("{:<10}", name), colour), clean(text));
  };
  put("tuple", name_of(tuple.owner, tuple.key));
  put("value", tuple.value);
  put("media type", tuple.media_type);
  put("seq", std::to_string(tuple.sequence));
  put("creator", std::to_string(number(tuple.creator)));
  put("written", when(tuple.write_time));
  put("measured", when(tuple.user_time));
  put("expires", tuple.expire_time == WallTime{} ? "never" : time_text(tuple.expire_time));
  if (!tuple.owner_present) put("owner", "absent");
  return out;
}

/// Wakes the sensor and takes the first value that is newer than what was there.
std::optional<Tuple> fresh_value(Session& session, const Target& target, const Tuple& old) {
  std::optional<Tuple> found;
  const auto subscription =
      session.client().tuples().subscribe({target.owner, target.key}, {}, [&](const Event& event) {
        const bool newer = event.tuple.sequence != old.sequence || event.tuple.write_time != old.write_time;
        if (event.kind == EventKind::kSet && newer && !event.tuple.value.empty()) found.emplace(event.tuple);
      });
  session.run([&] { return found.has_value(); }, session.settings().patience);
  return found;
}

void show(Session& session, const Tuple& tuple, const GetOptions& options, bool named) {
  auto& out = session.out();
  if (session.json()) return out.line(dump(tuple_json(tuple)));
  if (options.all) return out.write(all_text(tuple, session.now(), out.has_colour()));
  const auto value = out.is_terminal() ? clean(tuple.value) : tuple.value;
  out.line(named ? fmt::format("{} {}", name_of(tuple.owner, tuple.key), value) : value);
}

void explain_silence(const Tuple& tuple) {
  const auto parts = model::key_parts(tuple.key);
  const bool sensor = parts.size() == 6 && parts[3] == "sensor" && parts[5] == "value";
  if (sensor && tuple.value.empty()) say(fmt::format("{} has no value yet; --fresh asks the device", tuple.key));
}

int get_one(Session& session, const std::string& text, const GetOptions& options) {
  const auto typed = parse_target(text);
  if (!typed) {
    say(typed.error().text);
    return kUsage;
  }
  const auto candidates = resolve(session, *typed, "value");
  if (candidates.empty()) return session.nothing(fmt::format("no tuple {}", clean(text)));
  if (candidates.size() > 1) return ambiguous(text, candidates);
  const auto found = session.read({candidates[0].owner, candidates[0].key});
  if (found.empty()) return session.nothing(fmt::format("no tuple {} any more", clean(text)));
  const auto newer = options.fresh ? fresh_value(session, candidates[0], found[0]) : std::nullopt;
  if (options.fresh && !newer) {
    say(fmt::format("{} did not get a new value in time", name_of(candidates[0].owner, candidates[0].key)));
    return kTimedOut;
  }
  show(session, newer ? *newer : found[0], options, options.targets.size() > 1);
  if (!newer) explain_silence(found[0]);
  return kGood;
}

int get(Session& session, const GetOptions& options) {
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
       "  rubicon get living.illuminance-1\n"
       "  rubicon get --fresh living.illuminance-1     # ask the sensor, wait for what it says\n"
       "  rubicon get --all 6541:proxy.networks        # creator, times, media type, sequence number\n"},
      [options](Session& session) { return get(session, *options); });
  app->add_option("TUPLE", options->targets, "key, with ISLAND: in front where several have it; or DEVICE.POINT")
      ->required();
  app->add_flag("--all", options->all, "everything about it");
  app->add_flag("--fresh", options->fresh, "subscribe, so that its sensor measures, and wait for the next value");
}

}  // namespace rubicon::cli
