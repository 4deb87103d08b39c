#pragma once

#include <optional>
#include <string_view>

namespace rubicon::networks::zigbee::exposes {

/// What a leaf's spelling of a unit means: value in `code` = (number + shift) * multiply / divide.
struct LeafUnit {
  /// UCUM code as in the catalogue of types, `mired`, `{raw}`, ...; empty = no unit. Of an unknown spelling: the
  /// spelling.
  std::string_view code;
  double multiply = 1, divide = 1, shift = 0;
  bool known = true;
};

/// The unit of a numeric leaf (zigbee.md, section 11). `name` is the leaf's: it decides where a spelling has two
/// meanings (`m` = metres or minutes) and whether a temperature is a difference (kelvins, no shift). The field of a
/// clock (`start_hour`; hours up to 23) is not scaled. Spellings are compared exactly, then without blanks at their
/// ends.
LeafUnit unit_of(std::string_view spelling, std::string_view name, std::optional<double> maximum = std::nullopt);

}  // namespace rubicon::networks::zigbee::exposes
