#pragma once

#include <string_view>

namespace rubicon::base {

/// The order in which people list ids: runs of digits count as numbers (`wsn-2` before `wsn-10`, `1_0_7` before
/// `1_0_12`), all else byte by byte.
bool natural_less(std::string_view a, std::string_view b);

}  // namespace rubicon::base
