#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
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

/// What the `.status` beside a point says.
struct PointState {
  std::string quality, reason;
  WallTime heard{};     ///< zero = never
  std::string command;  ///< state of the last one
};
PointState point_state(std::string_view status);

/// Seconds since 1970 as in tuples; zero if it is none.
WallTime wall_time(double seconds);

/// `proxy.wsn-1.7.sensor.light-1.value` -> `proxy.wsn-1.7.sensor.light-1`.
std::string without_last_part(std::string_view key);
std::string_view last_part(std::string_view key);

/// The statuses of points, by owner and key of the point.
using PointStates = std::map<std::pair<OwnerId, std::string>, PointState>;
PointStates states_of(const std::vector<client::Tuple>& tuples);

}  // namespace rubicon::cli
