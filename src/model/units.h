#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace rubicon::model {

/// From one unit to another: (value + shift) * multiply / divide. Two factors, because 1/1000 has no exact double while
/// a quotient by 1000 is the nearest one.
struct UnitConversion {
  double multiply = 1, divide = 1;
  double shift = 0;

  /// What rounding left behind is gone: 12 digits.
  double operator()(double value) const;
};

/// Between UCUM codes, towards the units of the type catalogue. Nothing where there is none, or where it would depend
/// on what is measured (kelvins of a difference, decibels).
std::optional<UnitConversion> conversion(std::string_view from, std::string_view to);

/// The units that convert into `to`, comma separated; empty = none.
std::string units_of(std::string_view to);

}  // namespace rubicon::model
