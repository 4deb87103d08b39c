#pragma once

#include <string_view>

namespace rubicon::base {

/// The order in which people list ids: runs of digits count as numbers (`wsn-2` before `wsn-10`, `1_0_7` before
/// `1_0_12`). A word of 16 hexadecimal digits, with or without `0x` before it, is an IEEE address and no number:
/// addresses stand behind numbers, in the order of their texts. All else byte by byte.
bool natural_less(std::string_view a, std::string_view b);

}  // namespace rubicon::base
