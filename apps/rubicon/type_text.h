#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "model/type_catalogue.h"

namespace rubicon::cli {

/// `0..100`, `off|on`; without exponents up to 10^16. Empty where there is no bound.
std::string range_text(const Type& type);
/// The same of the JSON that describes a point (docs/tuple-keys.md).
std::string range_text(const nlohmann::json& description);

/// Whether a word finds a type: part of its name, quantity or unit (case does not matter), or its number.
bool found_by(const Type& type, std::string_view word);

}  // namespace rubicon::cli
