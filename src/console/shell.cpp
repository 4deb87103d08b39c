#include "console/shell.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/bytes.h"
#include "base/config_reader.h"
#include "base/nearest.h"
#include "base/printable.h"
#include "base/text.h"
#include "console/shell_words.h"
#include "model/json_members.h"
#include "model/message_cbor.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/key.hpp"
#include "tuples/tuple_json.h"

namespace rubicon::console {

namespace {

constexpr std::size_t kMaxSubscriptions = 1000;
constexpr Duration kShortestHeartbeat = std::chrono::milliseconds(10);

/// One word behind the pattern of `subscribe`.
Result<void> read_flow(std::string_view word, tuples::Flow& flow) {
  const auto value = word.substr(std::min(word.size(), word.find('=') + 1));
  if (word == "passive") {
    flow.passive = true;
    return {};
  }
  if (word.starts_with("min=") || word.starts_with("max=")) {
    const auto span = base::parse_duration(value);
    if (!span || (word.starts_with("max=") && *span < kShortestHeartbeat)) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: expected a duration such as 500ms, for max at least 10ms", model::quoted(word)));
    }
    (word.starts_with("min=") ? flow.minimum : flow.maximum) = *span;
    return {};
  }
  if (word.starts_with("deadband=")) {
    flow.dead_band = base::parse_number<double>(value).value_or(-1);
    if (flow.dead_band >= 0) return {};
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: expected min=SPAN, max=SPAN, deadband=NUMBER or passive", model::quoted(word)));
}

}  // namespace

const std::map<std::string_view, Shell::Command>& Shell::commands() {
  static const std::map<std::string_view, Command> all{
      {"set", {"set KEY[@SEQ] VALUE", &Shell::set}},
      {"append", {"append KEY[@SEQ] TEXT", &Shell::append}},
      {"link", {"link KEY TARGET", &Shell::link}},
      {"unlink", {"unlink KEY", &Shell::unlink}},
      {"get", {"get KEY", &Shell::get}},
      {"ls", {"ls PATTERN", &Shell::list}},
      {"subscribe", {"subscribe PATTERN [min=SPAN] [max=SPAN] [deadband=NUMBER] [passive]", &Shell::subscribe}},
      {"unsubscribe", {"unsubscribe PATTERN", &Shell::unsubscribe}},
      {"devices", {"devices", &Shell::devices}},
      {"stats", {"stats", &Shell::stats}},
      {"post", {"post HEX", &Shell::post}},
      {"inbox", {"inbox", &Shell::inbox}},
      {"approve", {"approve NETWORK.DEVICE", &Shell::approve}},
      {"ignore", {"ignore NETWORK.DEVICE", &Shell::ignore}},
      {"reload", {"reload [try]", &Shell::reload}},
      {"help", {"help", &Shell::help}},
      {"quit", {"quit", &Shell::quit}},
  };
  return all;
}

Shell::Shell(TupleSpace& space, OwnerId island, std::string prefix, Write answer, Write event,
             std::function<void()> quit)
    : space_(space),
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
  const auto found = commands().find(word);
  if (found == commands().end()) {
    std::vector<std::string> names;
    for (const auto& [name, command] : commands()) names.emplace_back(name);
    const auto near = base::did_you_mean(word, names);
    return fail_with(
        slot, ErrorCode::kInvalid,
        fmt::format("unknown command {}; {}", model::quoted(word), near.empty() ? "help lists the commands" : near));
  }
  (this->*found->second.run)(rest, slot);
}

void Shell::line_too_long() {
  if (quitting_) return;
  fail_with(slots_.emplace_back(std::make_shared<Answer>()), ErrorCode::kOutOfRange,
            fmt::format("line longer than {} bytes", kMaxLine));
}

void Shell::finish(const Slot& slot, std::string last_line) {
  slot->lines.push_back(std::move(last_line));
  slot->done = true;
  flush();
}

void Shell::fail_with(const Slot& slot, ErrorCode code, std::string text) {
  finish(slot, tuples::error_line({code, std::move(text)}));
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

void Shell::set(std::string_view rest, const Slot& slot) {
  write(false, rest, slot);
}

void Shell::post(std::string_view rest, const Slot& slot) {
  const auto bytes = base::from_hex(take_word(rest));
  if (!bytes || bytes->empty()) return fail_with(slot, ErrorCode::kInvalid, "expected: post HEX");
  remote_set(island_, "GATEWAY", base::as_text(*bytes), model::kMessageMediaType, slot);
}

void Shell::remote_set(OwnerId owner, const std::string& key, std::string_view value, std::string_view media_type,
                       const Slot& slot) {
  tuples::SetOptions options;
  options.media_type = media_type;
  space_.set_remote(owner, key, value, {}, reply_to(slot, owner, key), options);
}

tuples::ReplyCall Shell::reply_to(const Slot& slot, OwnerId owner, std::string key) {
  return lifetime_.guard([this, slot, key = std::move(key), owner](const tuples::Reply& reply) {
    const bool applied = reply.verdict == tuples::Verdict::kApplied;
    Line line{{"ok", applied},
              {"owner", number(owner)},
              {"key", key},
              {"verdict", to_string(reply.verdict)},
              {"request", reply.request}};
    if (reply.sequence != 0) line["seq"] = reply.sequence;
    if (!applied) {
      const auto code = reply.verdict == tuples::Verdict::kRefused       ? reply.code
                        : reply.verdict == tuples::Verdict::kNoSuchOwner ? ErrorCode::kNotFound
                                                                         : ErrorCode::kExpired;
      line["error"] = {{"code", to_string(code)}, {"text", reply.text}};
    }
    finish(slot, model::dump(line));
  });
}

void Shell::get(std::string_view rest, const Slot& slot) {
  const auto where = place(take_word(rest));
  if (!where) return fail_with(slot, where.error().code, where.error().text);
  const bool covered = where->owner == island_ || where->owner == space_.self();
  if (covered || space_.get(where->owner, where->key)) return answer_get(*where, slot);
  fetch(*where, slot);
}

void Shell::answer_get(const tuples::TupleName& name, const Slot& slot) {
  const auto tuple = space_.get(name.owner, name.key);
  if (!tuple) {
    return fail_with(slot, ErrorCode::kNotFound, fmt::format("no tuple {} of {}", name.key, number(name.owner)));
  }
  finish(slot, tuples::tuple_line(*tuple));
}

/// Of another component that no subscription covers: a passive one brings it, or shows that there is none.
void Shell::fetch(const tuples::TupleName& name, const Slot& slot) {
  const auto peers = space_.peers();
  if (std::find(peers.begin(), peers.end(), name.owner) == peers.end()) {
    return fail_with(slot, ErrorCode::kNotFound, fmt::format("no component {} is present", number(name.owner)));
  }
  const auto answered = [this, name, weak = std::weak_ptr(slot)] {  // the slots end with the shell
    const auto open = weak.lock();
    if (!open || open->done) return;
    answer_get(name, open);
    open->waits.clear();
  };
  slot->waits.push_back(space_.subscribe(
      {name.owner, name.key}, {{}, {}, 0, true}, [](const tuples::Event&) {}, [answered](OwnerId) { answered(); }));
  slot->waits.push_back(space_.watch_peers([answered, name](OwnerId peer, tuples::PeerEvent event) {
    if (peer == name.owner && event != tuples::PeerEvent::kUp) answered();
  }));
}

void Shell::list(std::string_view rest, const Slot& slot) {
  auto pattern = Pattern::parse(take_word(rest));
  if (!pattern) return fail_with(slot, pattern.error().code, pattern.error().text);
  if (!pattern->owner) pattern->owner = island_;
  std::size_t count = 0;
  space_.list(*pattern, [&](const tuples::TupleView& tuple) {
    ++count;
    slot->lines.push_back(
        model::dump({{"key", tuple.key}, {"value", tuples::value_text(tuple)}, {"mimetype", tuple.media_type}}));
  });
  finish(slot, model::dump({{"ok", true}, {"count", count}}));
}

void Shell::subscribe(std::string_view rest, const Slot& slot) {
  const auto name = take_word(rest);
  const bool through = name.starts_with(kArrow);
  const auto pattern = Pattern::parse(through ? name.substr(kArrow.size()) : name);
  if (!pattern) return fail_with(slot, pattern.error().code, pattern.error().text);
  if (through && !pattern->exact()) {
    return fail_with(slot, ErrorCode::kInvalid, fmt::format("{}: expected a key without *", model::quoted(name)));
  }
  tuples::Flow flow;
  for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
    if (auto read = read_flow(word, flow); !read) return fail_with(slot, read.error().code, read.error().text);
  }
  if (subscriptions_.size() >= kMaxSubscriptions && !subscriptions_.contains(std::string(name))) {
    return fail_with(slot, ErrorCode::kBusy, fmt::format("at most {} subscriptions", kMaxSubscriptions));
  }
  finish(slot, model::dump({{"ok", true}, {"subscribed", name}}));
  subscriptions_[std::string(name)] =
      through
          ? follow(name, *link_called(name.substr(kArrow.size())), flow)
          : space_.subscribe(*pattern, flow, [this](const tuples::Event& event) { event_(tuples::event_line(event)); });
}

void Shell::unsubscribe(std::string_view rest, const Slot& slot) {
  const std::string name(take_word(rest));
  if (subscriptions_.erase(name) == 0) {
    return fail_with(slot, ErrorCode::kNotFound, fmt::format("no subscription {}", model::quoted(name)));
  }
  finish(slot, model::dump({{"ok", true}, {"unsubscribed", name}}));
}

void Shell::devices(std::string_view, const Slot& slot) {
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
  finish(slot, model::dump({{"ok", true}, {"count", count}}));
}

void Shell::stats(std::string_view, const Slot& slot) {
  Line networks = Line::object();
  space_.list({island_, model::IslandKey{prefix_}.network("*").property("*")}, [&](const tuples::TupleView& tuple) {
    const auto parts = model::key_parts(tuple.key);
    networks[std::string(parts[1])][std::string(parts[3])] = tuples::value_text(tuple);
  });
  Line island = Line::object();
  space_.list({island_, model::IslandKey{prefix_}.property("*")}, [&](const tuples::TupleView& tuple) {
    island[std::string(model::key_parts(tuple.key)[2])] = tuples::value_text(tuple);
  });
  const auto own = space_.stats();
  finish(slot, model::dump({{"ok", true},
                            {"tuples", own.cached},
                            {"subscriptions", own.subscriptions},
                            {"events", own.events},
                            {"merged", own.merged},
                            {"dropped", own.dropped},
                            {"island", island},
                            {"networks", networks}}));
}

void Shell::help(std::string_view, const Slot& slot) {
  Line usage = Line::array();
  for (const auto& [name, command] : commands()) usage.push_back(command.usage);
  finish(slot, model::dump({{"ok", true}, {"commands", usage}}));
}

void Shell::quit(std::string_view, const Slot& slot) {
  quitting_ = true;
  finish(slot, model::dump({{"ok", true}}));
  when_idle(quit_);
}

}  // namespace rubicon::console
