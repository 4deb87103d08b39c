#include <fmt/format.h>

#include <algorithm>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/suggestions.h"
#include "apps/rubicon/target.h"
#include "apps/rubicon/time_option.h"
#include "apps/rubicon/tuple_text.h"
#include "base/bytes.h"
#include "client/remote_set_tracker.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

using client::Outcome;

constexpr Duration kUsualWait = std::chrono::seconds(15);

struct SetOptions {
  std::string target, value, ttl, wait, media_type = "text/plain", user_time, lifetime;
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

/// Says of a point that it takes no commands: kNotThere; kGood if it is not that.
int read_only(Session& session, const TypedTarget& typed) {
  const auto points = resolve(session, typed, "value");
  if (points.size() != 1 || !is_value_of_point(points.front().key)) return kGood;
  const auto point = model::parent_key(points.front().key);
  print_error(fmt::format("{} can only be read; {}", name_of(points.front().owner, point),
                          suggest_settable(session, points.front().owner, point)));
  return kNotThere;
}

/// The one tuple that is meant, or the exit code. With an owner and a whole key it may also be a tuple that is absent
/// yet: the owner decides.
struct Meant {
  std::optional<Target> target;
  int code = kGood;
};
Meant meant(Session& session, const std::string& text, std::string_view last) {
  const auto typed = parse_target(session, text);
  if (!typed) {
    print_error(typed.error().text);
    return {{}, kUsage};
  }
  if (typed->owner && !long_form(*typed, last)) return {Target{*typed->owner, typed->key}, kGood};
  auto candidates = resolve(session, *typed, last);
  if (candidates.empty() && last == "command") {
    if (const int code = read_only(session, *typed); code != kGood) return {{}, code};
  }
  if (candidates.empty() && typed->owner) return {Target{*typed->owner, typed->key}, kGood};
  if (candidates.empty()) {
    return {{},
            session.not_found(fmt::format("no tuple {} that could be set", printable(text)),
                              suggest_tuple(session, text, last))};
  }
  if (candidates.size() > 1) return {{}, ambiguous(text, candidates)};
  return {std::move(candidates[0]), kGood};
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
  client.run_until([&] { return outcome.has_value(); }, Duration::max());
  return *outcome;
}

int set(Session& session, const SetOptions& options) {
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
  if (!session.run([&] { return outcome.has_value(); })) outcome = Outcome{"timed-out", "ended by a signal", 0, {}};
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
  app->add_option("TUPLE", options.target, "key, with OWNER: in front where several have it; or DEVICE.POINT")
      ->required();
  add_duration_option(app, "--ttl", options.ttl, "time to live: what waits for longer expires; 5s if not given");
}

}  // namespace

void add_set(Cli& cli) {
  const auto options = std::make_shared<SetOptions>();
  auto* app = cli.command_in_ecology(
      {"set", "Set a tuple of another component; for a .command wait for the outcome",
       "  rubicon set living.lamp-1 on\n"
       "  rubicon set 6541:proxy.dummy-rooms.living.actuator.lamp-1.command off --ttl 1min\n"
       "  rubicon set --json living.lamp-1 on | jq .state\n"
       "  rubicon set 70001:robot.goal kitchen --user-time now --lifetime 1min\n"
       "  rubicon set 6541:GATEWAY --media-type application/rubicon+cbor --hex a2617601646b696e64666f7061717565\n"
       "The exit code says how it ended: 0 confirmed, assumed or applied; 3 refused, 4 failed, "
       "5 timed-out, 6 expired,\n"
       "7 superseded, 8 no such component or tuple. What a command waits for stands on standard error.\n"},
      [options](Session& session) { return set(session, *options); });
  add_target(app, *options);
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

}  // namespace rubicon::cli
