#pragma once

#include <cstddef>
#include <string>

#include "island/island_config.h"
#include "transport/transports.h"

namespace rubicon::island {

/// Tells two contents of the file that the network's options name (NetworkType::file_option) apart; 0 = there is no
/// such option, or the file cannot be read. Reads at most kLargestOptionsFile bytes of it.
std::size_t digest_of_options_file(const island::NetworkSetup& setup, const std::string& directory,
                                   transport::Transports& transports);
inline constexpr std::size_t kLargestOptionsFile = 64 << 20;

}  // namespace rubicon::island
