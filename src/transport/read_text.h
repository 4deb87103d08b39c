#pragma once

#include <string>

#include "transport/transports.h"

namespace rubicon::transport {

/// A whole file that belongs to a configuration. kOutOfRange beyond `largest` bytes; else what open_file and read say.
/// For start-up and reloads: it blocks.
Result<std::string> read_text(Transports& transports, const std::string& path, std::size_t largest);

}  // namespace rubicon::transport
