#include <fmt/format.h>

#include "base/bytes.h"
#include "console/shell.h"
#include "model/json_members.h"
#include "model/message.h"
#include "model/point_keys.h"
#include "tuples/tuple_json.h"

namespace rubicon::console {

namespace {

/// Meta tuples one shell may own.
constexpr std::size_t kMaxLinks = 1000;

/// `KEY` of the island or `OWNER:KEY`, without wildcards.
Result<tuples::TupleName> read_name(std::string_view text, OwnerId island) {
  auto pattern = Pattern::parse(text);
  if (!pattern) return fail(pattern.error());
  if (!pattern->exact()) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected a key without *", model::quoted(text)));
  }
  return tuples::TupleName{pattern->owner.value_or(island), std::move(pattern->key)};
}

}  // namespace

/// A meta tuple without an owner is the shell's own, as for `link`; where the shell has none of that name, the
/// island's.
Result<tuples::TupleName> Shell::link_called(std::string_view word) const {
  auto name = read_name(word, space_.self());
  const bool has_owner = word.find(':') != word.npos;
  if (name && !has_owner && !space_.find(name->key)) name->owner = island_;
  return name;
}

Result<std::string> Shell::place(std::string_view word) const {
  if (!word.starts_with(kArrow))
    return word.find(':') == word.npos ? fmt::format("{}:{}", number(island_), word) : std::string(word);
  const auto name = link_called(word.substr(kArrow.size()));
  if (!name) return fail(name.error());
  const auto tuple = tuples::get_through(space_, *name);
  if (!tuple) return fail(tuple.error());
  return to_string(tuples::TupleName{tuple->owner, std::string(tuple->key)});
}

/// `KEY[@SEQ] VALUE`
void Shell::write(std::string_view verb, std::string_view rest, const Slot& slot) {
  const auto word = take_word(rest);
  const auto at = word.find('@');
  const auto key = place(word.substr(0, at));
  if (!key) return fail_with(slot, key.error());
  Members members(nlohmann::json{{"key", *key}, {"value", rest}});
  if (at != word.npos) members.add("sequence", word.substr(at + 1));
  run(verb, members, slot);
}

void Shell::get_word(std::string_view, std::string_view rest, const Slot& slot) {
  const auto key = place(take_word(rest));
  if (!key) return fail_with(slot, key.error());
  Members members(nlohmann::json{{"key", *key}});
  run("get", members, slot);
}

/// `PATTERN [NAME=TEXT]...`; without `passive` it wakes the sensors.
void Shell::subscribe_word(std::string_view, std::string_view rest, const Slot& slot) {
  const auto name = take_word(rest);
  Members members(nlohmann::json{{"pattern", name.substr(name.starts_with(kArrow) ? kArrow.size() : 0)}});
  for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
    const auto equals = word.find('=');
    const bool has_value = equals != word.npos;
    members.add(word.substr(0, equals), has_value ? nlohmann::json(word.substr(equals + 1)) : nlohmann::json(true));
  }
  if (!members.has("active") && !members.flag("passive")) members.add("active", true);
  if (auto good = resolve("subscribe", members); !good) return fail_with(slot, good.error());
  subscribe(members, slot, name);
}

void Shell::unsubscribe_word(std::string_view, std::string_view rest, const Slot& slot) {
  const auto name = take_word(rest);
  if (std::erase_if(subscriptions_, [name](const auto& one) { return one.second.name == name; }) > 0)
    return finish(slot);
  fail_with(slot, {ErrorCode::kNotFound, fmt::format("no subscription {}", model::quoted(name))});
}

void Shell::post(std::string_view, std::string_view rest, const Slot& slot) {
  const auto bytes = base::from_hex(take_word(rest));
  if (!bytes || bytes->empty()) return fail_with(slot, {ErrorCode::kInvalid, "expected: post HEX"});
  send({island_, "GATEWAY", std::string(base::as_text(*bytes)), std::string(model::kMessageMediaType)}, slot);
}

/// The one command whose KEY without an owner is the shell's own: it makes a tuple, and others cannot be made from
/// here.
void Shell::link(std::string_view, std::string_view rest, const Slot& slot) {
  const auto meta = read_name(take_word(rest), space_.self());
  if (!meta) return fail_with(slot, meta.error());
  const auto target = read_name(take_word(rest), island_);
  if (!target) return fail_with(slot, target.error());
  if (meta->owner != space_.self()) {
    const auto sent = set_reference(space_, *meta, *target, {}, reply_to(slot, meta->owner, meta->key));
    if (!sent) fail_with(slot, sent.error());
    return;
  }
  if (space_.stats().own >= kMaxLinks && !space_.find(meta->key)) {
    return fail_with(slot, {ErrorCode::kBusy, fmt::format("at most {} links", kMaxLinks)});
  }
  const auto linked = set_reference(space_, meta->key, *target);
  if (!linked) return fail_with(slot, linked.error());
  finish(slot, {{"linked", to_string(*meta)}, {"target", to_string(*target)}});
}

void Shell::unlink(std::string_view, std::string_view rest, const Slot& slot) {
  const auto meta = read_name(take_word(rest), space_.self());
  if (!meta) return fail_with(slot, meta.error());
  if (meta->owner != space_.self()) {
    return fail_with(
        slot, {ErrorCode::kRefused, fmt::format("{} belongs to another component; only links of {} can be removed here",
                                                to_string(*meta), number(space_.self()))});
  }
  const auto erased = space_.erase(meta->key);
  if (!erased) return fail_with(slot, erased.error());
  finish(slot, {{"unlinked", to_string(*meta)}});
}

tuples::Handle Shell::follow(std::string_view name, const tuples::TupleName& meta, const tuples::Flow& flow) {
  const std::string through(name);
  return subscribe_through(
      space_, meta, flow, [this, through](const tuples::Event& event) { event_(tuples::event_line(event, through)); },
      [this, through](const Result<tuples::TupleName>& target) {
        verbs::Line line{{"through", through}};
        if (target) {
          line["target"] = to_string(*target);
        } else {
          line["error"] = verbs::error_json(target.error());
        }
        line["event"] = target ? "target" : "unresolved";
        event_(model::dump(line));
      });
}

/// One line for each waiting device, as its tuple says.
void Shell::inbox(std::string_view, std::string_view, const Slot& slot) {
  std::size_t count = 0;
  space_.list({island_, model::IslandKey{prefix_}.inbox("*.*")}, [&](const tuples::TupleView& tuple) {
    ++count;
    slot->lines.emplace_back(tuple.value);
  });
  const auto all = space_.get(island_, model::IslandKey{prefix_}.inbox());
  const auto ignored = model::count_of(model::object_of(all ? all->value : std::string_view()), "ignored");
  finish(slot, {{"count", count}, {"ignored", ignored}});
}

/// `wsn-1.7` is one device, a word with * or ? all that wait and fit it.
void Shell::decide(std::string_view word, std::string_view rest, const Slot& slot) {
  const auto which = take_word(rest);
  if (which.empty()) return fail_with(slot, {ErrorCode::kInvalid, fmt::format("expected: {} NETWORK.DEVICE", word)});
  const model::IslandKey island{prefix_};
  const bool is_pattern = which.find_first_of("*?") != which.npos;
  verbs::Set decision{island_, is_pattern ? island.inbox() : island.inbox(which), std::string(word), "text/plain"};
  if (is_pattern) decision.value += " " + std::string(which);
  send(decision, slot);
}

void Shell::reload(std::string_view, std::string_view rest, const Slot& slot) {
  const auto word = take_word(rest);
  if (!word.empty() && word != "try") return fail_with(slot, {ErrorCode::kInvalid, "expected: reload [try]"});
  if (!reload_) return fail_with(slot, {ErrorCode::kUnsupported, "this program cannot reload its configuration"});
  const auto done = reload_(word == "try");
  if (!done) return fail_with(slot, done.error());
  finish(slot, {{"changes", *done}});
}

}  // namespace rubicon::console
