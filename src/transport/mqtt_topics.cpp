#include "transport/mqtt_topics.h"

#include <algorithm>

#include "base/utf8.h"

namespace rubicon::transport {

namespace {

constexpr std::size_t kLongestText = 65535;
constexpr std::ptrdiff_t kMostLevels = 200;

/// Brokers and clients may refuse the others (MQTT 5, section 1.5.4), and libmosquitto does.
bool is_mqtt_character(char32_t code) {
  const bool control = code < 0x20 || (code >= 0x7f && code <= 0x9f);
  const bool noncharacter = (code >= 0xfdd0 && code <= 0xfdef) || (code & 0xfffe) == 0xfffe;
  return !control && !noncharacter;
}

bool has_few_levels(std::string_view topic) {
  return std::count(topic.begin(), topic.end(), '/') < kMostLevels;
}

/// Takes the first level and its `/` away; `more` = a level follows, which may be empty.
std::string_view take_level(std::string_view& text, bool& more) {
  const auto end = text.find('/');
  const auto level = text.substr(0, end);
  more = end != text.npos;
  text.remove_prefix(more ? end + 1 : text.size());
  return level;
}

}  // namespace

bool is_mqtt_text(std::string_view text) {
  if (text.empty() || text.size() > kLongestText) return false;
  while (!text.empty()) {
    const auto character = base::take_utf8(text);
    if (!character || !is_mqtt_character(*character)) return false;
  }
  return true;
}

bool is_mqtt_topic(std::string_view topic) {
  return is_mqtt_text(topic) && has_few_levels(topic) && topic.find_first_of("+#") == topic.npos;
}

bool is_mqtt_filter(std::string_view filter) {
  if (!is_mqtt_text(filter) || !has_few_levels(filter)) return false;
  for (bool more = true; more;) {
    const auto level = take_level(filter, more);
    if (level == "#" && more) return false;
    if (level.size() > 1 && level.find_first_of("+#") != level.npos) return false;
  }
  return true;
}

bool mqtt_matches(std::string_view filter, std::string_view topic) {
  if (topic.starts_with('$') && !filter.starts_with('$')) return false;
  for (bool more_filter = true, more_topic = true;;) {
    const auto wanted = take_level(filter, more_filter);
    if (wanted == "#") return true;
    const auto level = take_level(topic, more_topic);
    if (wanted != "+" && wanted != level) return false;
    if (!more_topic) return !more_filter || filter == "#";  // `a/#` matches `a` too
    if (!more_filter) return false;
  }
}

}  // namespace rubicon::transport
