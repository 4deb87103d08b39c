#include "model/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::model {

nlohmann::json parse_json(std::string_view text) {
  return nlohmann::json::parse(text, nullptr, false);
}

nlohmann::ordered_json parse_ordered_json(std::string_view text) {
  return nlohmann::ordered_json::parse(text, nullptr, false);
}

bool is_json(std::string_view text) {
  return nlohmann::json::accept(text);
}

std::string dump(const nlohmann::ordered_json& tree) {
  return tree.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string dump_sorted(const nlohmann::json& tree) {
  return tree.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string dump_ascii(const nlohmann::json& tree) {
  return tree.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

WallTime time_from_seconds(double seconds) {
  constexpr double kMaxTime = 1e11;  // beyond the year 5000
  if (!(seconds > 0 && seconds < kMaxTime)) return {};
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
  constexpr std::int64_t kSecond = 1'000'000;
  const auto micros = time.time_since_epoch().count();
  std::array<char, 32> text{};
  auto* end = std::to_chars(text.data(), text.data() + text.size(), micros / kSecond).ptr;
  auto rest = micros % kSecond;
  if (rest > 0) *end++ = '.';
  for (auto place = kSecond / 10; rest > 0; place /= 10) {
    *end++ = static_cast<char>('0' + rest / place);
    rest %= place;
  }
  out.append(text.data(), end);
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
