#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"

namespace rubicon::cli {

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
