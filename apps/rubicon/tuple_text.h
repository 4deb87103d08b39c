#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "rubicon/client.hpp"

namespace rubicon::cli {

using Line = nlohmann::ordered_json;

/// One line of JSON; broken UTF-8 is replaced.
std::string dump(const Line& line);
/// The members of an object; none if the text is none.
nlohmann::json object_of(std::string_view text);
/// Empty, 0 or false, where a member is missing or of another kind.
std::string text_in(const nlohmann::json& object, const char* name);
double number_in(const nlohmann::json& object, const char* name);
bool flag_in(const nlohmann::json& object, const char* name);
/// Zero also where a whole number is negative or too large.
std::uint64_t count_in(const nlohmann::json& object, const char* name);

/// owner, key, value or value_hex, mimetype, seq, write, user, creator, expire, and present: false where the owner is
/// not there. The names and times of `rubicon-proxy run --watch`.
Line tuple_json(const client::Tuple& tuple);
/// `6541:proxy.wsn-1.7.status`.
std::string name_of(OwnerId owner, std::string_view key);

/// The same, for points (not for other tuples) with quality, reason, heard, changed, line and line_reason. The one form
/// in which `get`, `ls` and `watch` show them.
Line point_json(const client::Point& point);
/// `stale: not heard for 3s`; empty for what is no point.
std::string quality_text(const client::Point& point);
/// `down: connection refused`, `up`.
std::string line_text(const LineStatus& line);
/// `next attempt in 12s`, `next attempt now`; empty where none is planned.
std::string next_attempt_text(const LineStatus& line, WallTime now);
/// Whether the key is that of the value of a sensor, actuator or property.
bool is_value_of_point(std::string_view key);
/// The points whose values the pattern names, as Client::read_points takes them; nullopt: it names other tuples, too.
std::optional<Pattern> points_of(const Pattern& pattern);

/// Seconds since 1970 as in tuples; zero if it is none.
WallTime wall_time(double seconds);

/// `proxy.wsn-1.7.sensor.light-1.value` -> `proxy.wsn-1.7.sensor.light-1`.
std::string without_last_part(std::string_view key);
std::string_view last_part(std::string_view key);

}  // namespace rubicon::cli
