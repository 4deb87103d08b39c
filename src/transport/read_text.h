#pragma once

#include <string>

#include "transport/transports.h"

namespace rubicon::transport {

/// Reads a whole file of the configuration. kOutOfRange if it is longer than `largest` bytes, else the errors of
/// open_file() and read(). Blocks: for start-up and reloads.
Result<std::string> read_text(Transports& transports, const std::string& path, std::size_t largest);

}  // namespace rubicon::transport
