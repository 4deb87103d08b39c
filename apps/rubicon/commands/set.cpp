#include <fmt/format.h>

#include <algorithm>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "apps/rubicon/targets/selection.h"
#include "apps/rubicon/targets/suggestions.h"
#include "base/bytes.h"
#include "client/remote_set_tracker.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

using client::Outcome;

constexpr Duration kUsualWait = std::chrono::seconds(15);

struct SetOptions {
  IslandOption island{};
  std::string target{}, value{}, ttl{}, wait{}, media_type = "text/plain", user_time{}, lifetime{};
  bool hex = false;
};

std::string seconds_text(Duration took) {
  return fmt::format("{:.2f} s", std::chrono::duration<double>(took).count());
}

/// Of a command that was refused: perhaps because there is no such tuple.
void look_closer(Session& session, const Target& target, Outcome& outcome) {
  if (outcome.state == "refused" && session.read({target.owner, target.key}).empty()) outcome.state = "no-such-tuple";
}

int tell(Session& session, const Target& target, const std::string& value, const Outcome& outcome, Duration took) {
  if (session.json()) {
    Line line;
    line["owner"] = number(target.owner);
    line["key"] = target.key;
    line["value"] = value;
    line["state"] = outcome.state;
    line["reason"] = outcome.reason;
    line["request"] = outcome.request;
    line["seconds"] = std::chrono::duration<double>(took).count();
    session.out().line(model::dump(line));
    return exit_code_of(outcome.state);
  }
  const auto text = fmt::format("{} after {}{}{}", painted(outcome.state, outcome.state, session.look().colour),
                                seconds_text(took), outcome.reason.empty() ? "" : ": ", printable(outcome.reason));
  session.out().line(fmt::format("{} {}", name_of(target.owner, target.key), text));
  return exit_code_of(outcome.state);
}

/// Says of points that they take no commands: kNotThere; kGood if there are none.
int read_only(Session& session, const std::string& text) {
  const auto points = targets_called(session, text, "value");
  if (!points || points->empty() || !is_value_of_point(points->front().key)) return kGood;
  const auto& [owner, key] = points->front();
  const auto point = model::parent_key(key);
  print_error(fmt::format("{} can only be read; {}", points->size() == 1 ? name_of(owner, point) : model::quoted(text),
                          suggest_settable(session, owner, point)));
  return kNotThere;
}

/// The one tuple that is meant, or the exit code. With an owner and a whole key it may also be a tuple that is absent
/// yet: the owner decides.
struct Meant {
  std::optional<Target> target;
  int code = kGood;
};
/// The owner of a whole key decides; a short name of an island's point is looked for.
bool is_whole(Session& session, const TypedTarget& typed) {
  if (!model::is_island(*typed.owner) || typed.key.starts_with(session.settings().prefix + ".")) return true;
  return typed.key.find('.') == std::string::npos;
}

Meant meant(Session& session, const std::string& text, std::string_view last) {
  const auto typed = parse_target(session, text);
  const bool has_owner = typed && typed->owner;
  if (has_owner && is_whole(session, *typed) && !long_form(*typed, last))
    return {Target{*typed->owner, typed->key}, kGood};
  auto candidates = targets_called(session, text, last);
  if (!candidates) {
    print_error(candidates.error().text);
    return {{}, kUsage};
  }
  if (candidates->empty() && last == "command") {
    if (const int code = read_only(session, text); code != kGood) return {{}, code};
  }
  if (candidates->empty() && has_owner && is_whole(session, *typed)) return {Target{*typed->owner, typed->key}, kGood};
  if (candidates->empty()) {
    return {{},
            session.not_found(fmt::format("no tuple {} that could be set", printable(text)),
                              suggest_tuple(session, text, last))};
  }
  if (candidates->size() > 1) return {{}, ambiguous(text, *candidates)};
  return {std::move(candidates->front()), kGood};
}

/// Says on standard error what a command waits for, once it has waited for a moment.
class Waiting {
 public:
  explicit Waiting(Session& session) : session_(session) {}

  void update(const Outcome& outcome) {
    if (outcome.reason == said_.reason) return;
    said_ = outcome;
    pause_ = session_.client().after(kMoment, [this] { tell(); });
  }

 private:
  static constexpr Duration kMoment = std::chrono::milliseconds(500);

  void tell() {
    const auto left = std::chrono::duration<double>(said_.until - session_.now()).count();
    print_error(fmt::format("{}: {}{}", said_.state, printable(said_.reason),
                            left > 0 ? fmt::format(" (at most {:.1f} s more)", left) : std::string()));
  }

  Session& session_;
  Outcome said_;
  Handle pause_;
};

/// Until it is known whether the owner is there.
void find_owner(Session& session, OwnerId owner) {
  session.client().run_until([&] { return session.client().has(owner).has_value(); }, session.patience_left());
}

/// Sets the tuple and follows the command until its outcome is known.
Outcome command(Session& session, const Target& target, const SetOptions& options, const std::string& value) {
  auto& client = session.client();
  find_owner(session, target.owner);
  tuples::SetOptions more{.media_type = options.media_type, .lifetime = parse_duration_or(options.lifetime)};
  if (!options.user_time.empty()) more.user_time = time_in(options.user_time, session.now()).value_or(WallTime{});
  std::optional<Outcome> outcome;
  Waiting waiting(session);
  const client::RemoteSetTracker tracker(
      client.scheduler(), client.tuples(), target.owner, target.key, value,
      [&](const Outcome& last) { outcome = last; }, parse_duration_or(options.ttl),
      parse_duration_or(options.wait, kUsualWait), [&](const Outcome& now) { waiting.update(now); }, {}, more);
  session.run([&] { return outcome.has_value(); });
  return outcome.value_or(kEndedBySignal);
}

int set(Session& session, SetOptions options) {
  if (const int code = options.island.put_before(session, options.target); code != kGood) return code;
  auto value = options.value;
  if (options.hex) {
    const auto bytes = base::from_hex(value);
    if (!bytes) {
      print_error(bytes.error().text);
      return kUsage;
    }
    value = base::as_text(*bytes);
  }
  const auto which = meant(session, options.target, "command");
  if (!which.target) return which.code;
  const auto start = std::chrono::steady_clock::now();
  auto outcome = command(session, *which.target, options, value);
  const auto took = std::chrono::steady_clock::now() - start;
  look_closer(session, *which.target, outcome);
  return tell(session, *which.target, options.value, outcome, took);
}

Outcome outcome_of(const Reply& reply) {
  return {reply.verdict == Verdict::kApplied ? "applied" : std::string(to_string(reply.verdict)),
          reply.text,
          reply.request,
          {}};
}

/// Waits for the owner's reply to what `ask` sends.
int ask(Session& session, const SetOptions& options,
        const std::function<void(TupleSpace&, const Target&, tuples::ReplyCall)>& send) {
  const auto which = meant(session, options.target, "value");
  if (!which.target) return which.code;
  find_owner(session, which.target->owner);
  std::optional<Outcome> outcome;
  const auto start = std::chrono::steady_clock::now();
  send(session.client().tuples(), *which.target, [&](const Reply& reply) { outcome = outcome_of(reply); });
  if (!session.run([&] { return outcome.has_value(); })) outcome = kEndedBySignal;
  look_closer(session, *which.target, *outcome);
  return tell(session, *which.target, options.value, *outcome, std::chrono::steady_clock::now() - start);
}

int append(Session& session, const SetOptions& options) {
  return ask(session, options, [&](TupleSpace& space, const Target& target, tuples::ReplyCall call) {
    space.append_remote(target.owner, target.key, options.value, parse_duration_or(options.ttl), std::move(call),
                        {.media_type = ""});
  });
}

/// Only its owner can delete a tuple: asks the owner to let it expire at once.
int erase(Session& session, const SetOptions& options) {
  return ask(session, options, [&](TupleSpace& space, const Target& target, tuples::ReplyCall call) {
    space.set_remote(target.owner, target.key, "", parse_duration_or(options.ttl), std::move(call),
                     {.lifetime = std::chrono::milliseconds(1)});
  });
}

void add_target(CLI::App* app, SetOptions& options) {
  app->add_option("TUPLE", options.target,
                  "key, or DEVICE.POINT by key or name; with OWNER: in front where several have it")
      ->required();
  add_duration_option(app, "--ttl", options.ttl, "time to live: what waits for longer expires; 5s if not given");
}

}  // namespace

void add_set(Cli& cli) {
  const auto options = std::make_shared<SetOptions>();
  auto* app = cli.command_in_ecology(
      {"set", "Set a tuple of another component; for a .command wait for the outcome",
       "  rubicon set living.lamp-1 on\n"
       "  rubicon set 'Living room.lamp' off           # by the name of the device, and the type\n"
       "  rubicon set 6541:proxy.dummy-rooms.living.actuator.lamp-1.command off --ttl 1min\n"
       "  rubicon set --json living.lamp-1 on | jq .state\n"
       "  rubicon set 70001:robot.goal kitchen --user-time now --lifetime 1min\n"
       "  rubicon set 6541:GATEWAY --media-type application/rubicon+cbor --hex a2617601646b696e64666f7061717565\n"
       "The exit code says how it ended: 0 confirmed, assumed or applied; 3 refused, 4 failed, "
       "5 timed-out, 6 expired,\n"
       "7 superseded, 8 no such component or tuple. What a command waits for stands on standard error.\n"},
      [options](Session& session) { return set(session, *options); });
  add_target(app, *options);
  options->island.add_to(app);
  app->add_option("VALUE", options->value, "as text, in the unit of the point")->required();
  add_duration_option(app, "--wait", options->wait,
                      "wait for so long for news of a command that must have ended, 15s if not given");
  app->add_option("--media-type", options->media_type, "media type of the value")->capture_default_str();
  add_time_option(app, "--user-time", options->user_time, "when the value was measured");
  add_duration_option(app, "--lifetime", options->lifetime, "the tuple expires so long after it was written");
  app->add_flag("--hex", options->hex, "VALUE is bytes in hex");

  const auto more = std::make_shared<SetOptions>();
  app = cli.command_in_ecology({"append", "Add text behind the value of a tuple, if its owner lets others do that",
                                "  rubicon append 70001:robot.log 'dock reached'\n"},
                               [more](Session& session) { return append(session, *more); });
  add_target(app, *more);
  app->add_option("TEXT", more->value, "what is added")->required();

  const auto gone = std::make_shared<SetOptions>();
  app = cli.command_in_ecology({"delete", "Ask the owner of a tuple to let it expire at once",
                                "  rubicon delete 70001:robot.goal      # rubicon publish --open: others may\n"
                                "Tuples of devices go with their devices: islands refuse.\n"},
                               [gone](Session& session) { return erase(session, *gone); });
  add_target(app, *gone);
}

namespace {

struct PublishOptions {
  AsOptions as;
  std::string key, value, media_type = "text/plain", length;
  bool open = false;
};

/// Lets the deletion reach other components before the program ends.
constexpr Duration kFarewell = std::chrono::milliseconds(200);

int publish(Session& session, const PublishOptions& options) {
  auto& space = session.client().tuples();
  if (auto set = space.set(options.key, options.value, {.media_type = options.media_type}); !set) {
    print_error(set.error().text);
    return kUsage;
  }
  Handle policy, news;
  if (options.open) {
    const Pattern own{space.self(), options.key};
    policy = space.add_policy(
        own, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
        tuples::PolicyScope::kSetsAndAppends);
    news = space.subscribe(own, {}, [&session](const Event& event) {
      if (event.kind != EventKind::kSet) return;
      session.out().line(session.json() ? model::dump(tuple_json(client::Tuple(event.tuple)))
                                        : printable(event.tuple.value));
    });
  }
  print_error(fmt::format("{} exists until this program ends", name_of(space.self(), options.key)));
  const auto gone = [&] { return !space.find(options.key); };  // others may delete what is open
  session.run(gone, parse_duration_or(options.length, Duration::max()));
  news.reset();
  std::ignore = space.erase(options.key);
  session.client().run_until([] { return false; }, kFarewell);
  return kGood;
}

}  // namespace

void add_publish(Cli& cli) {
  const auto options = std::make_shared<PublishOptions>();
  auto* app =
      cli.command({"publish", "Publish a tuple while the program runs",
                   "  rubicon publish robot.battery 87 --name robot --for 1min\n"
                   "  rubicon publish robot.goal kitchen --id 70001 --open    # prints each value that others set\n"},
                  [options](const Settings& settings) {
                    const auto session = Session::open(options->as.applied(settings), "publish");
                    return session ? session->end(publish(*session, *options)) : static_cast<int>(kFailed);
                  });
  app->add_option("KEY", options->key, "parts of letters, digits, _ and -, with dots between them")->required();
  app->add_option("VALUE", options->value, "its value")->required();
  app->add_option("--media-type", options->media_type, "media type of the value")->capture_default_str();
  app->add_flag("--open", options->open, "others may set, append to and delete it; each value is printed");
  options->as.add_to(*app);
  add_duration_option(app, "--for", options->length, "end after this time");
}

}  // namespace rubicon::cli
