#pragma once

#include <cstddef>
#include <string_view>

namespace rubicon::networks::zigbee::exposes {

/// Levels of brackets in JSON of devices and definitions (zigbee.md, section 3.1: composites may nest).
inline constexpr std::size_t kDeepestJson = 32;

/// Whether brackets outside strings nest deeper than kDeepestJson. Bounds the recursion of whoever reads the text.
bool is_deep(std::string_view json);

}  // namespace rubicon::networks::zigbee::exposes
