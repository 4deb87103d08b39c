#include <fmt/format.h>

#include <set>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/completion.h"
#include "apps/rubicon/completion_scripts.h"
#include "apps/rubicon/target.h"
#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/site/commands.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

/// Short, because a user waits at the keyboard.
constexpr Duration kPatience = std::chrono::milliseconds(700);

struct Words {
  std::vector<std::string> before;
  std::string typed;
};

std::set<std::string> keys(Client& client, const std::string& typed, const std::string& prefix) {
  std::set<std::string> found;
  for (const auto& question : questions_for(typed, prefix)) {
    for (const auto& tuple : client.read(question, kPatience)) {
      const auto name = question.owner ? name_of(tuple.owner, tuple.key) : tuple.key;
      if (auto next = next_step(name, typed); !next.empty()) found.insert(std::move(next));
    }
  }
  return found;
}

std::set<std::string> devices(Client& client) {
  std::set<std::string> found;
  for (const auto& device : client.devices({}, kPatience)) {
    found.insert(device.id);
    found.insert(device.network + "." + device.id);
  }
  return found;
}

std::set<std::string> points(Client& client) {
  std::set<std::string> found;
  for (const auto& device : client.devices({}, kPatience)) {
    for (const auto* list : {&device.sensors, &device.actuators, &device.properties}) {
      for (const auto& id : *list) found.insert(device.id + "." + id);
    }
  }
  return found;
}

/// The words of the actuator that is to be set.
std::set<std::string> values(Client& client, const std::string& tuple) {
  const auto typed = parse_target(tuple);
  if (!typed) return {};
  const auto longer = long_form(*typed, "description");
  const Pattern pattern =
      longer.value_or(Pattern{typed->owner, model::PointKey{std::string(model::parent_key(typed->key))}.description()});
  std::set<std::string> found;
  for (const auto& one : client.read(pattern, kPatience)) {
    const auto words = value_words(one.value);
    found.insert(words.begin(), words.end());
  }
  return found;
}

std::set<std::string> live(const Settings& settings, const Question& question, const std::string& typed) {
  auto options = settings.options;
  options.name = "rubicon complete";
  auto client = Client::open(options);
  if (!client) return {};
  (*client)->discover();
  std::set<std::string> found;
  switch (question.wanted) {
    case Wanted::kTuple: {
      found = keys(**client, typed, settings.prefix);
      found.merge(points(**client));
      break;
    }
    case Wanted::kValue: return values(**client, question.tuple);
    case Wanted::kDevice: return devices(**client);
    case Wanted::kComponent:
      for (const auto& one : (*client)->components()) found.insert(std::to_string(number(one.id)));
      break;
    case Wanted::kWaiting:
      for (const auto& tuple :
           (*client)->read({std::nullopt, model::IslandKey{settings.prefix}.inbox("*.*")}, kPatience))
        found.insert(model::text_of(model::object_of(tuple.value), "key"));
      break;
    case Wanted::kMember:
    case Wanted::kNoFile:
    case Wanted::kNothing: break;
  }
  return found;
}

std::set<std::string> realm_members() {
  std::set<std::string> found;
  const auto there = rubicon::trust::site::contents_of(trust::site::folder_to_show(""), trust::now());
  if (!there) return found;
  for (const auto& one : there->members) found.insert(one.name);
  return found;
}

std::set<std::string> found_for(const Settings& settings, const Question& question, const std::string& typed) {
  switch (question.wanted) {
    case Wanted::kNothing:
    case Wanted::kNoFile: return {};
    case Wanted::kMember: return realm_members();
    default: return live(settings, question, typed);
  }
}

bool is_no_file(Wanted wanted) {
  return wanted == Wanted::kMember || wanted == Wanted::kNoFile;
}

int complete(const CLI::App& app, const Settings& settings, const std::vector<std::string>& words) {
  Output out(1);
  const auto typed = words.empty() ? std::string() : words.back();
  std::vector<std::string> before(words.begin(), words.empty() ? words.end() : words.end() - 1);
  auto offers = fixed_offers(app, before, typed);
  const auto question = wanted_at(app, before);
  const bool takes_no_file = is_no_file(question.wanted);
  if (offers.empty()) {
    for (const auto& one : found_for(settings, question, typed)) offers.push_back(one);
  }
  bool is_offered = false;
  for (const auto& one : offers) {
    if (!one.starts_with(typed)) continue;
    out.line(printable(one));
    is_offered = true;
  }
  if (takes_no_file && !is_offered) out.line(kNoFiles);
  return ended(out, kGood);
}

}  // namespace

void add_complete(Cli& cli) {
  const auto words = std::make_shared<std::vector<std::string>>();
  auto* app = cli.command(
      {"complete", "Offer what the last of these words may become, for shells", "  rubicon complete -- watch proxy.\n"},
      [words, &cli](const Settings& settings) { return complete(cli.app(), settings, *words); });
  app->add_option("WORD", *words, "the words of a command line behind the name of the program");
  app->group("");
}

}  // namespace rubicon::cli
