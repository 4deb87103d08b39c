#pragma once

#include <string>

#include "model/point_tuples.h"
#include "model/type_catalogue.h"

namespace rubicon::cli {

/// `0..100`, `off|on`; without exponents up to 10^16. Empty where there is no bound.
std::string range_text(const Type& type);
/// The same of a point.
std::string range_text(const model::PointDescription& description);

/// Whether a word finds a type: part of its name, quantity or unit (case does not matter), or its number.
bool found_by(const Type& type, std::string_view word);

}  // namespace rubicon::cli
