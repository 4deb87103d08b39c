#pragma once

#include <string>
#include <string_view>

namespace rubicon::networks::knx::project {

/// The id in the application program of what is in an instance of a module, or of a module in a module:
/// `MD-2_M-20_MI-1_O-2_R-3` -> `MD-2_O-2_R-3`, and `MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2_SM-1_O-3_R-2` ->
/// `MD-4_SM-1_O-3_R-2`. `module` becomes the instance: `MD-2_M-20_MI-1`; it stays as it is for other ids (knx.md,
/// section 21.9).
std::string without_module(std::string_view id, std::string& module);

}  // namespace rubicon::networks::knx::project
