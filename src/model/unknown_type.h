#pragma once

#include <string>
#include <string_view>

#include "model/type_catalogue.h"

namespace rubicon::model {

/// For a configuration that names a type which the catalogue does not have: `unknown type 'temprature'; did you mean
/// 'temperature'? expected ...`.
std::string unknown_type_text(const TypeCatalogue& types, std::string_view name);

}  // namespace rubicon::model
