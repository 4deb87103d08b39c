#include "apps/rubicon/tuple_text.h"

#include <fmt/format.h>

#include <cmath>

#include "base/bytes.h"
#include "runtime/event_json.h"

namespace rubicon::cli {

namespace {

/// Of `<prefix>.<network>.<device>.<kind>.<id>.status`.
constexpr std::size_t kPointParts = 6;

}  // namespace

std::string dump(const Line& line) {
  return line.dump(-1, ' ', false, Line::error_handler_t::replace);
}

nlohmann::json object_of(std::string_view text) {
  auto tree = nlohmann::json::parse(text, nullptr, false);
  return tree.is_object() ? tree : nlohmann::json::object();
}

std::string text_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

double number_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0;
}

bool flag_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}

std::uint64_t count_in(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

Line tuple_json(const client::Tuple& tuple) {
  Line line;
  line["owner"] = number(tuple.owner);
  line["key"] = tuple.key;
  if (runtime::is_utf8(tuple.value)) {
    line["value"] = tuple.value;
  } else {
    line["value_hex"] = base::to_hex(base::as_bytes(tuple.value));
  }
  line["mimetype"] = tuple.media_type;
  line["seq"] = tuple.sequence;
  line["write"] = base::to_seconds(tuple.write_time);
  line["user"] = base::to_seconds(tuple.user_time);
  line["creator"] = number(tuple.creator);
  line["expire"] = base::to_seconds(tuple.expire_time);
  if (!tuple.owner_present) line["present"] = false;
  return line;
}

std::string name_of(OwnerId owner, std::string_view key) {
  return fmt::format("{}:{}", number(owner), key);
}

WallTime wall_time(double seconds) {
  constexpr double kLatest = 1e11;
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return WallTime(std::chrono::microseconds(std::llround(seconds * 1e6)));
}

PointState point_state(std::string_view status) {
  const auto tree = object_of(status);
  PointState state{text_in(tree, "quality"), text_in(tree, "reason"), wall_time(number_in(tree, "heard")), ""};
  if (const auto command = tree.find("command"); command != tree.end() && command->is_object())
    state.command = text_in(*command, "state");
  return state;
}

std::string without_last_part(std::string_view key) {
  const auto dot = key.rfind('.');
  return std::string(key.substr(0, dot == key.npos ? 0 : dot));
}

std::string_view last_part(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

PointStates states_of(const std::vector<client::Tuple>& tuples) {
  PointStates states;
  for (const auto& tuple : tuples) {
    if (last_part(tuple.key) == "status" && model::key_parts(tuple.key).size() == kPointParts)
      states[{tuple.owner, without_last_part(tuple.key)}] = point_state(tuple.value);
  }
  return states;
}

}  // namespace rubicon::cli
