#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

namespace rubicon::model {

/// Structured value, kept as JSON text.
struct Json {
  std::string text;
  friend bool operator==(const Json&, const Json&) = default;
};

/// What a sensor measured or an actuator shall do, in the unit of its type. Enumerations travel as their word,
/// booleans as bool. monostate = nothing known.
using Value = std::variant<std::monostate, bool, std::int64_t, double, std::string, Json>;

/// The text of a value as in tuples: `on`/`off`, `21`, `21.5` (shortest form that reads back the same), the
/// word, the JSON. NaN and infinities, which no type permits, give an empty text as monostate does.
std::string to_text(const Value& value);
/// Same, into a string that keeps its memory: for the path of every reading.
void to_text(const Value& value, std::string& out);

/// `text/plain`, or `application/json` for Json.
std::string_view media_type(const Value& value);

}  // namespace rubicon::model

namespace rubicon {
using model::Json;
using model::Value;
}  // namespace rubicon
