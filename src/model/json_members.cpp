#include "model/json_members.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/append.h"

namespace rubicon::model {

WallTime time_from_seconds(double seconds) {
  constexpr double kLatest = 1e11;  // beyond the year 5000
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return WallTime(std::chrono::microseconds(std::llround(seconds * 1e6)));
}

nlohmann::ordered_json seconds_json(WallTime time) {
  const auto micros = time.time_since_epoch().count();
  if (micros % 1000000 == 0) return micros / 1000000;
  return base::to_seconds(time);
}

nlohmann::json object_of(std::string_view text) {
  auto tree = parse_json(text);
  return tree.is_object() ? tree : nlohmann::json::object();
}

void append_seconds(WallTime time, std::string& out) {
  const auto micros = time.time_since_epoch().count();
  base::append(out, "{}", micros / 1000000);
  auto rest = micros % 1000000;
  if (rest <= 0) return;
  int digits = 6;
  for (; rest % 10 == 0; rest /= 10) --digits;
  base::append(out, ".{:0{}}", rest, digits);
}

void append_json(std::string_view text, std::string& out) {
  const auto is_plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
  if (!std::all_of(text.begin(), text.end(), is_plain)) {
    out += dump(nlohmann::json(text));
    return;
  }
  out += '"';
  out += text;
  out += '"';
}

}  // namespace rubicon::model
