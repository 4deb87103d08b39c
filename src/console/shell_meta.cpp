#include <fmt/format.h>

#include "console/shell.h"
#include "console/shell_words.h"
#include "model/json_members.h"
#include "tuples/tuple_json.h"

namespace rubicon::console {

namespace {

/// Meta tuples one shell may own.
constexpr std::size_t kMaxLinks = 1000;

}  // namespace

/// A meta tuple without an owner is the shell's own, as for `link`; where the shell has none of that name, the
/// island's.
Result<tuples::TupleName> Shell::link_called(std::string_view word) const {
  auto name = read_name(word, space_.self());
  const bool has_owner = word.find(':') != word.npos;
  if (name && !has_owner && !space_.find(name->key)) name->owner = island_;
  return name;
}

Result<tuples::TupleName> Shell::place(std::string_view word) const {
  if (!word.starts_with(kArrow)) return read_name(word, island_);
  auto name = link_called(word.substr(kArrow.size()));
  if (!name) return name;
  const auto tuple = tuples::get_through(space_, *name);
  if (!tuple) return fail(tuple.error());
  return tuples::TupleName{tuple->owner, std::string(tuple->key)};
}

void Shell::append(std::string_view rest, const Slot& slot) {
  write(true, rest, slot);
}

void Shell::write(bool append, std::string_view rest, const Slot& slot) {
  auto word = take_word(rest);
  const auto sequence = take_sequence(word);
  if (!sequence) return fail_with(slot, sequence.error().code, sequence.error().text);
  const auto where = place(word);
  if (!where) return fail_with(slot, where.error().code, where.error().text);
  tuples::SetOptions options;
  options.expected_sequence = *sequence;
  auto answered = reply_to(slot, where->owner, where->key);
  if (append) {
    space_.append_remote(where->owner, where->key, rest, {}, std::move(answered), options);
  } else {
    space_.set_remote(where->owner, where->key, rest, {}, std::move(answered), options);
  }
}

/// The one command whose KEY without an owner is the shell's own: it makes a tuple, and others cannot be made from
/// here.
void Shell::link(std::string_view rest, const Slot& slot) {
  const auto meta = read_name(take_word(rest), space_.self());
  if (!meta) return fail_with(slot, meta.error().code, meta.error().text);
  const auto target = read_name(take_word(rest), island_);
  if (!target) return fail_with(slot, target.error().code, target.error().text);
  if (meta->owner != space_.self()) {
    const auto sent = set_reference(space_, *meta, *target, {}, reply_to(slot, meta->owner, meta->key));
    if (!sent) fail_with(slot, sent.error().code, sent.error().text);
    return;
  }
  if (space_.stats().own >= kMaxLinks && !space_.find(meta->key)) {
    return fail_with(slot, ErrorCode::kBusy, fmt::format("at most {} links", kMaxLinks));
  }
  const auto linked = set_reference(space_, meta->key, *target);
  if (!linked) return fail_with(slot, linked.error().code, linked.error().text);
  finish(slot, model::dump({{"ok", true}, {"linked", to_string(*meta)}, {"target", to_string(*target)}}));
}

void Shell::unlink(std::string_view rest, const Slot& slot) {
  const auto meta = read_name(take_word(rest), space_.self());
  if (!meta) return fail_with(slot, meta.error().code, meta.error().text);
  if (meta->owner != space_.self()) {
    return fail_with(slot, ErrorCode::kRefused,
                     fmt::format("{} belongs to another component; only links of {} can be removed here",
                                 to_string(*meta), number(space_.self())));
  }
  const auto erased = space_.erase(meta->key);
  if (!erased) return fail_with(slot, erased.error().code, erased.error().text);
  finish(slot, model::dump({{"ok", true}, {"unlinked", to_string(*meta)}}));
}

tuples::Handle Shell::follow(std::string_view name, const tuples::TupleName& meta, const tuples::Flow& flow) {
  const std::string through(name);
  return subscribe_through(
      space_, meta, flow, [this, through](const tuples::Event& event) { event_(tuples::event_line(event, through)); },
      [this, through](const Result<tuples::TupleName>& target) {
        Line line{{"through", through}};
        if (target) {
          line["target"] = to_string(*target);
        } else {
          line["error"] = {{"code", to_string(target.error().code)}, {"text", target.error().text}};
        }
        line["event"] = target ? "target" : "unresolved";
        event_(model::dump(line));
      });
}

}  // namespace rubicon::console
