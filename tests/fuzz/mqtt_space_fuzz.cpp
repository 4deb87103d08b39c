#include <cstdlib>

#include "fuzz_target.h"
#include "tuples/mqtt/messages.h"
#include "tuples/mqtt/topics.h"

namespace rubicon::fuzz::mqtt_space_fuzz {

namespace {

using namespace rubicon::tuples::mqtt;

/// What was understood must be written and read alike.
void check_topic(std::string_view text) {
  const Topics topics("default");
  const auto at = topics.parse(text);
  if (const auto* presence = std::get_if<Topics::Presence>(&at)) {
    const auto same =
        presence->component ? topics.component(presence->line, *presence->component) : topics.line(presence->line);
    if (same != text) std::abort();
  }
  if (const auto user = topics.user_of_document(text)) {
    if (topics.document(*user) != text || !std::holds_alternative<std::monostate>(at)) std::abort();
  }
  if (const auto* inbox = std::get_if<Topics::Inbox>(&at); inbox && topics.inbox(inbox->to, inbox->from) != text)
    std::abort();
}

void check_presence(std::string_view payload) {
  if (const auto line = read_line(payload)) {
    const auto again = read_line(line_text(*line));
    if (!again || again->count != line->count || again->lease != line->lease) std::abort();
  }
  if (const auto component = read_component(payload)) {
    const auto again = read_component(component_text(*component));
    if (!again || again->incarnation != component->incarnation || again->host != component->host ||
        again->summary != component->summary)
      std::abort();
  }
}

/// What was unpacked comes back, packed or as it is.
void check_packed(ByteView received) {
  static Packing packing;
  Bytes into, again;
  const auto plain = packing.unpacked(received, into);
  if (!plain) return;
  if (plain->size() > Packing::kMaxUnpacked && !into.empty()) std::abort();
  const auto packed = packing.packed(*plain);
  if (!packed) return;
  const auto same = packing.unpacked(*packed, again);
  if (!same || base::as_text(*same) != base::as_text(*plain)) std::abort();
}

void check_frame(ByteView frame) {
  ByteView entries;
  const auto head = read_head(frame, entries);
  if (!head) return;
  ByteView same;
  const auto bytes = frame_of(*head, entries);
  const auto again = read_head(bytes, same);
  if (!again || again->source != head->source || again->stream != head->stream || again->number != head->number ||
      again->heard != head->heard || again->credit != head->credit || again->again != head->again ||
      base::as_text(same) != base::as_text(entries))
    std::abort();
}

}  // namespace

/// Input: a topic, presence and a frame at once.
FUZZ_TARGET(mqtt_space) {
  const ByteView input(data, size);
  check_topic(base::as_text(input));
  check_presence(base::as_text(input));
  check_packed(input);
  check_frame(input);
  return 0;
}

}  // namespace rubicon::fuzz::mqtt_space_fuzz
