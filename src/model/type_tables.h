#pragma once

#include <limits>
#include <span>

#include "model/type_catalogue.h"

namespace rubicon::model {

/// No bound, in the columns of least and greatest value.
inline constexpr double kNone = std::numeric_limits<double>::infinity();

/// The built-in types, one table a theme; ids are for ever. The number ranges are listed in docs/types.md.
std::span<const Type> mote_types();      ///< 0x0001..0x007f: transducers and actuators of the motes, activity sets
std::span<const Type> register_types();  ///< 0x0100..0x01ff: general digital and analogue inputs and outputs
std::span<const Type> home_types();      ///< 0x0200..0x03ff: homes and buildings
std::span<const Type> quantity_types();  ///< 0x0400..0x05ff: physical quantities
std::span<const Type> property_types();  ///< 0x0600..0x06ff: properties of devices

}  // namespace rubicon::model
