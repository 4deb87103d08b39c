#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "model/point_tuples.h"
#include "model/type_catalogue.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

using Line = nlohmann::ordered_json;

/// owner, key, value or value_hex, mimetype, seq, write, user, creator, expire, and present: false where the owner is
/// not there. The names and times of `rubicon-proxy run --watch`.
Line tuple_json(const client::Tuple& tuple);
/// `6541:proxy.wsn-1.7.status`.
std::string name_of(OwnerId owner, std::string_view key);

/// The same, for points (not for other tuples) with quality, reason, heard, changed, line and line_reason. The one form
/// in which `get`, `ls` and `watch` show them.
Line point_json(const client::Point& point);
/// `stale: not heard for 3s`; empty for what is not a point.
std::string quality_text(const client::Point& point);
/// `down: connection refused`, `up`.
std::string line_text(const LineStatus& line);
/// `next attempt in 12s`, `next attempt now`; empty where none is planned.
std::string next_attempt_text(const LineStatus& line, WallTime now);
/// Whether the key names the value of a sensor, actuator or property.
bool is_value_of_point(std::string_view key);
/// The points whose values the pattern names, as Client::read_points takes them; nullopt: it names other tuples, too.
std::optional<Pattern> points_of(const Pattern& pattern);

/// `0..100`, `off|on`; without exponents up to 10^16. Empty where there is no bound.
std::string range_text(const Type& type);
/// The same of a point.
std::string range_text(const model::PointDescription& description);

/// Whether a word finds a type: part of its name, quantity or unit (case does not matter), or its number.
bool found_by(const Type& type, std::string_view word);

}  // namespace rubicon::cli
