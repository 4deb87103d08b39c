#include "console/shell.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/compare_text.h"
#include "client/target_search.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/key.hpp"
#include "tuples/tuple_json.h"

namespace rubicon::console {

namespace {

constexpr std::size_t kMaxSubscriptions = 1000;
/// The largest whole number that every JSON parser keeps exactly.
constexpr std::uint64_t kMaxId = 1ULL << 53U;

}  // namespace

std::string_view take_word(std::string_view& rest) {
  const auto begin = rest.find_first_not_of(" \t");
  if (begin == rest.npos) {
    rest = {};
    return {};
  }
  rest.remove_prefix(begin);
  const auto word = rest.substr(0, rest.find_first_of(" \t"));
  rest.remove_prefix(word.size());
  if (!rest.empty()) rest.remove_prefix(1);
  return word;
}

const std::map<std::string_view, Shell::Command>& Shell::commands() {
  static const std::map<std::string_view, Command> all{
      {"set", {"set KEY[@SEQ] VALUE", &Shell::write}},
      {"append", {"append KEY[@SEQ] TEXT", &Shell::write}},
      {"link", {"link KEY TARGET", &Shell::link}},
      {"unlink", {"unlink KEY", &Shell::unlink}},
      {"get", {"get KEY", &Shell::get_word}},
      {"ls", {"ls PATTERN", &Shell::list}},
      {"subscribe", {"subscribe PATTERN [min=SPAN] [max=SPAN] [deadband=NUMBER] [passive]", &Shell::subscribe_word}},
      {"unsubscribe", {"unsubscribe PATTERN", &Shell::unsubscribe_word}},
      {"devices", {"devices", &Shell::devices}},
      {"stats", {"stats", &Shell::stats}},
      {"post", {"post HEX", &Shell::post}},
      {"inbox", {"inbox", &Shell::inbox}},
      {"approve", {"approve NETWORK.DEVICE", &Shell::decide}},
      {"ignore", {"ignore NETWORK.DEVICE", &Shell::decide}},
      {"reload", {"reload [try]", &Shell::reload}},
      {"help", {"help", &Shell::help}},
      {"quit", {"quit", &Shell::quit}},
  };
  return all;
}

Shell::Shell(Scheduler& scheduler, TupleSpace& space, OwnerId island, std::string prefix, Write answer, Write event,
             std::function<void()> quit)
    : scheduler_(scheduler),
      space_(space),
      island_(island),
      prefix_(std::move(prefix)),
      answer_(std::move(answer)),
      event_(std::move(event)),
      quit_(std::move(quit)),
      everything_(space.subscribe({island, "**"}, {{}, {}, 0, true}, [](const tuples::Event&) {})) {}

Shell::~Shell() = default;

void Shell::line(std::string_view text) {
  if (quitting_) return;
  if (text.ends_with('\r')) text.remove_suffix(1);
  auto rest = text;
  const auto word = take_word(rest);
  if (word.empty() || word.starts_with('#')) return;
  const auto slot = slots_.emplace_back(std::make_shared<Answer>());
  if (word.starts_with('{')) return request(text, slot);
  const auto found = commands().find(word);
  if (found == commands().end()) {
    std::vector<std::string> names;
    for (const auto& [name, command] : commands()) names.emplace_back(name);
    const auto near = base::did_you_mean(word, names);
    return fail_with(slot, {ErrorCode::kInvalid, fmt::format("unknown command {}; {}", model::quoted(word),
                                                             near.empty() ? "help lists the commands" : near)});
  }
  (this->*found->second.run)(word, rest, slot);
}

void Shell::line_too_long() {
  if (quitting_) return;
  fail_with(slots_.emplace_back(std::make_shared<Answer>()),
            {ErrorCode::kOutOfRange, fmt::format("line longer than {} bytes", kMaxLine)});
}

void Shell::finish(const Slot& slot, const verbs::Line& content, const Result<void>& done) {
  slot->lines.push_back(verbs::answer_line(slot->begin, done, content));
  slot->done = true;
  flush();
}

void Shell::fail_with(const Slot& slot, Error error) {
  finish(slot, verbs::Line::object(), fail(std::move(error)));
}

void Shell::flush() {
  while (!slots_.empty() && slots_.front()->done) {
    const auto slot = slots_.front();
    slots_.pop_front();
    for (auto& line : slot->lines) answer_(std::move(line));
  }
  if (slots_.empty() && idle_) std::exchange(idle_, nullptr)();
}

void Shell::when_idle(std::function<void()> call) {
  idle_ = std::move(call);
  flush();
}

void Shell::request(std::string_view line, const Slot& slot) {
  auto tree = verbs::parse_object(line);
  if (!tree) return fail_with(slot, tree.error());
  Members members(std::move(*tree));
  if (const auto id = members.count("id", 0, kMaxId)) slot->begin["id"] = *id;
  run(members.text("do", "a verb, such as subscribe"), members, slot);
}

/// All tuples of the island are here: the search ends before this does.
Result<void> Shell::resolve(std::string_view verb, Members& members) const {
  const auto naming = verbs::naming_of(verb);
  const auto text = naming ? members.peek(naming->member) : std::string();
  const bool is_pattern = verb == "subscribe";
  if (text.empty() || !(is_pattern ? client::is_name_among_patterns : client::is_name)(space_, text)) return {};
  const auto read = [this](const Pattern& pattern, const client::TuplesCall& call) {
    std::vector<client::Tuple> found;
    space_.list({pattern.owner.value_or(island_), pattern.key},
                [&](const tuples::TupleView& tuple) { found.emplace_back(tuple); });
    call(std::move(found));
  };
  Result<client::Target> key = client::Target();
  client::TargetSearch search(client::islands_in(space_), text, std::string(naming->last), read,
                              [&](Result<client::Findings> findings) {
                                key = findings ? client::the_one(*findings, text) : fail(findings.error());
                              });
  search.start();
  if (key) return members.resolve(naming->member, to_string(*key)), Result<void>();
  const bool is_key = Pattern::parse(text).has_value() && (is_pattern || text.find(':') != text.npos);
  if (is_key && key.error().code == ErrorCode::kNotFound) return {};
  return fail(key.error());
}

void Shell::run(std::string_view verb, Members& members, const Slot& slot) {
  if (auto good = resolve(verb, members); !good) return fail_with(slot, good.error());
  if (verb == "subscribe") return subscribe(members, slot);
  if (verb == "get") {
    const auto tuple = verbs::read_get(members);
    return tuple ? get(*tuple, slot) : fail_with(slot, tuple.error());
  }
  if (verb == "set" || verb == "append") {
    const auto wanted = verbs::read_set(members, verb == "append", scheduler_.wall_now());
    return wanted ? send(*wanted, slot) : fail_with(slot, wanted.error());
  }
  if (verb == "unsubscribe") {
    const auto number = verbs::read_unsubscribe(members);
    if (!number) return fail_with(slot, number.error());
    if (subscriptions_.erase(*number) > 0) return finish(slot);
    return fail_with(slot, {ErrorCode::kNotFound, fmt::format("no subscription {}", *number)});
  }
  members.fault(verbs::no_verb(verb, {"append", "get", "set", "subscribe", "unsubscribe"}).text);
  fail_with(slot, members.end().error());
}

void Shell::send(const verbs::Set& set, const Slot& slot) {
  verbs::send(space_, set, reply_to(slot, set.owner, set.key));
}

tuples::ReplyCall Shell::reply_to(const Slot& slot, OwnerId owner, std::string key) {
  return lifetime_.guard([this, slot, key = std::move(key), owner](const tuples::Reply& reply) {
    verbs::Line line{{"owner", number(owner)}, {"key", key}};
    line.update(verbs::reply_json(reply));
    finish(slot, line, verbs::verdict_of(reply, owner));
  });
}

void Shell::get(const Pattern& tuple, const Slot& slot) {
  const bool is_covered = tuple.owner == island_ || tuple.owner == space_.self();
  if (is_covered || space_.get(*tuple.owner, tuple.key)) return answer_get(tuple, slot);
  fetch(tuple, slot);
}

void Shell::answer_get(const Pattern& tuple, const Slot& slot) {
  const auto there = space_.get(*tuple.owner, tuple.key);
  if (!there) return fail_with(slot, verbs::no_tuple(space_, tuple));
  finish(slot, {{"tuple", verbs::tuple_json(*there)}});
}

/// Of another component that no subscription covers: a passive one brings it, or shows that there is none.
void Shell::fetch(const Pattern& tuple, const Slot& slot) {
  const auto peers = space_.peers();
  if (std::find(peers.begin(), peers.end(), *tuple.owner) == peers.end()) return answer_get(tuple, slot);
  const auto answered = [this, tuple, weak = std::weak_ptr(slot)] {  // the slots end with the shell
    const auto open = weak.lock();
    if (!open || open->done) return;
    answer_get(tuple, open);
    open->waits.clear();
  };
  slot->waits.push_back(space_.subscribe(
      tuple, {{}, {}, 0, true}, [](const tuples::Event&) {}, [answered](OwnerId) { answered(); }));
  slot->waits.push_back(space_.watch_peers([answered, tuple](OwnerId peer, tuples::PeerEvent event) {
    if (peer == tuple.owner && event != tuples::PeerEvent::kUp) answered();
  }));
}

void Shell::subscribe(Members& members, const Slot& slot, std::string_view name) {
  const auto wanted = verbs::read_subscription(members);
  if (!wanted) return fail_with(slot, wanted.error());
  const bool is_through = name.starts_with(kArrow);
  const auto meta = is_through ? link_called(name.substr(kArrow.size())) : tuples::TupleName{};
  if (!meta) return fail_with(slot, meta.error());
  if (!name.empty()) std::erase_if(subscriptions_, [&](const auto& one) { return one.second.name == name; });
  if (subscriptions_.size() >= kMaxSubscriptions)
    return fail_with(slot, {ErrorCode::kBusy, fmt::format("at most {} subscriptions", kMaxSubscriptions)});
  finish(slot, {{"subscription", ++last_subscription_}});
  auto& made = subscriptions_[last_subscription_];
  made.name = name;  // of a request it has none: words do not end it
  const tuples::Flow flow{wanted->minimum.value_or(Duration(0)), wanted->maximum, wanted->dead_band, !wanted->active};
  const auto show = [this](const tuples::Event& event) { event_(tuples::event_line(event)); };
  made.handle = is_through ? follow(name, *meta, flow) : space_.subscribe(wanted->pattern, flow, show);
}

void Shell::list(std::string_view, std::string_view rest, const Slot& slot) {
  auto pattern = Pattern::parse(take_word(rest));
  if (!pattern) return fail_with(slot, pattern.error());
  if (!pattern->owner) pattern->owner = island_;
  std::size_t count = 0;
  space_.list(*pattern, [&](const tuples::TupleView& tuple) {
    ++count;
    slot->lines.push_back(model::dump(verbs::tuple_json(tuple)));
  });
  finish(slot, {{"count", count}});
}

void Shell::devices(std::string_view, std::string_view, const Slot& slot) {
  std::size_t count = 0;
  const auto any_device = model::IslandKey{prefix_}.network("*").device("*");
  space_.list({island_, any_device.status()}, [&](const tuples::TupleView& tuple) {
    if (model::is_of_island(tuple.key)) return;
    const model::DeviceKey device{std::string(model::parent_key(tuple.key))};
    const auto condition = model::device_condition_from_json(tuple.value);
    const auto about = space_.get(island_, device.description());
    const auto description = model::device_description_from_json(about ? about->value : std::string_view());
    ++count;
    slot->lines.push_back(model::dump({{"device", device.text},
                                       {"name", description ? description->name : ""},
                                       {"status", condition.status.empty() ? "unknown" : condition.status},
                                       {"since", model::seconds_json(condition.since)}}));
  });
  finish(slot, {{"count", count}});
}

void Shell::stats(std::string_view, std::string_view, const Slot& slot) {
  auto networks = verbs::Line::object();
  space_.list({island_, model::IslandKey{prefix_}.network("*").property("*")}, [&](const tuples::TupleView& tuple) {
    const auto parts = model::key_parts(tuple.key);
    networks[std::string(parts[1])][std::string(parts[3])] = tuples::value_text(tuple);
  });
  auto island = verbs::Line::object();
  space_.list({island_, model::IslandKey{prefix_}.property("*")}, [&](const tuples::TupleView& tuple) {
    island[std::string(model::key_parts(tuple.key)[2])] = tuples::value_text(tuple);
  });
  const auto own = space_.stats();
  finish(slot, {{"tuples", own.cached},
                {"subscriptions", own.subscriptions},
                {"events", own.events},
                {"merged", own.merged},
                {"dropped", own.dropped},
                {"island", island},
                {"networks", networks}});
}

void Shell::help(std::string_view, std::string_view, const Slot& slot) {
  auto usage = verbs::Line::array();
  for (const auto& [name, command] : commands()) usage.push_back(command.usage);
  finish(slot, {{"commands", usage}});
}

void Shell::quit(std::string_view, std::string_view, const Slot& slot) {
  quitting_ = true;
  finish(slot);
  when_idle(quit_);
}

}  // namespace rubicon::console
