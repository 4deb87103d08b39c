#include <fmt/format.h>

#include "console/shell.h"
#include "console/shell_words.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "tuples/tuple_json.h"

namespace rubicon::console {

/// One line for each waiting device, as its tuple says.
void Shell::inbox(std::string_view, const Slot& slot) {
  std::size_t count = 0;
  space_.list({island_, model::IslandKey{prefix_}.inbox("*.*")}, [&](const tuples::TupleView& tuple) {
    ++count;
    slot->lines.emplace_back(tuple.value);
  });
  const auto all = space_.get(island_, model::IslandKey{prefix_}.inbox());
  const auto ignored = model::count_of(model::object_of(all ? all->value : std::string_view()), "ignored");
  finish(slot, model::dump({{"ok", true}, {"count", count}, {"ignored", ignored}}));
}

void Shell::approve(std::string_view rest, const Slot& slot) {
  decide("approve", rest, slot);
}

void Shell::ignore(std::string_view rest, const Slot& slot) {
  decide("ignore", rest, slot);
}

/// `wsn-1.7` is one device, a word with * or ? all that wait and fit it.
void Shell::decide(std::string_view word, std::string_view rest, const Slot& slot) {
  const auto which = take_word(rest);
  if (which.empty()) return fail_with(slot, ErrorCode::kInvalid, fmt::format("expected: {} NETWORK.DEVICE", word));
  const model::IslandKey island{prefix_};
  if (which.find_first_of("*?") != which.npos) {
    return remote_set(island_, island.inbox(), fmt::format("{} {}", word, which), "text/plain", slot);
  }
  remote_set(island_, island.inbox(which), word, "text/plain", slot);
}

void Shell::reload(std::string_view rest, const Slot& slot) {
  const auto word = take_word(rest);
  if (!word.empty() && word != "try") return fail_with(slot, ErrorCode::kInvalid, "expected: reload [try]");
  if (!reload_) return fail_with(slot, ErrorCode::kUnsupported, "this program cannot reload its configuration");
  const auto done = reload_(word == "try");
  if (!done) return fail_with(slot, done.error().code, done.error().text);
  finish(slot, model::dump({{"ok", true}, {"changes", *done}}));
}

}  // namespace rubicon::console
