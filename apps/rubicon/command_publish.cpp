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

/// Others take it for gone when it is: the deletion is on its way before the program ends.
constexpr Duration kFarewell = std::chrono::milliseconds(200);

int publish(Session& session, const PublishOptions& options) {
  auto& space = session.client().tuples();
  if (auto set = space.set(options.key, options.value, {.media_type = options.media_type}); !set) {
    say(set.error().text);
    return kUsage;
  }
  Handle judge, news;
  if (options.open) {
    const Pattern own{space.self(), options.key};
    judge = space.add_policy(
        own, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
        tuples::PolicyScope::kSetsAndAppends);
    news = space.subscribe(own, {}, [&session](const Event& event) {
      if (event.kind != EventKind::kSet) return;
      session.out().line(session.json() ? model::dump(tuple_json(client::Tuple(event.tuple)))
                                        : clean(event.tuple.value));
    });
  }
  say(fmt::format("{} is there until this program ends", name_of(space.self(), options.key)));
  const auto gone = [&] { return !space.find(options.key); };  // others may delete what is open
  session.run(gone, span_of(options.length, Duration::max()));
  news.reset();
  std::ignore = space.erase(options.key);
  session.client().run_until([] { return false; }, kFarewell);
  return kGood;
}

}  // namespace

void add_publish(Cli& cli) {
  const auto options = std::make_shared<PublishOptions>();
  auto* app =
      cli.command({"publish", "Have a tuple of this program's own while it runs",
                   "  rubicon publish robot.battery 87 --name robot --for 1min\n"
                   "  rubicon publish robot.goal kitchen --id 70001 --open    # shows what others make of it\n"},
                  [options](const Settings& settings) {
                    const auto session = Session::open(options->as.applied(settings), "publish");
                    return session ? session->end(publish(*session, *options)) : static_cast<int>(kFailed);
                  });
  app->add_option("KEY", options->key, "parts of letters, digits, _ and -, with dots between them")->required();
  app->add_option("VALUE", options->value, "what it says")->required();
  app->add_option("--media-type", options->media_type, "what the value is")->capture_default_str();
  app->add_flag("--open", options->open, "others may set it, append to it and delete it; each value is shown");
  options->as.add_to(*app);
  add_span(app, "--for", options->length, "end after this time");
}

}  // namespace rubicon::cli
