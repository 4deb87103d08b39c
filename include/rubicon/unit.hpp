#pragma once

#include <string>
#include <string_view>

namespace rubicon::model {

/// A UCUM code as people write it: `Cel` -> `°C`, `[ppm]` -> `ppm`, `ug/m3` -> `µg/m³`, `kW.h` -> `kWh`; empty for `1`.
/// What it does not know stays as it is. For people only: tuples and JSON keep the code.
std::string unit_text(std::string_view code);

}  // namespace rubicon::model

namespace rubicon {
using model::unit_text;
}  // namespace rubicon
