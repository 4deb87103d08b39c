#pragma once

#include <cstdint>

#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::networks::knx::project {

/// What the end of an archive says of its list of entries.
struct ArchiveEnd {
  std::uint64_t entries = 0;    ///< the most that any of its end records claims
  std::uint64_t directory = 0;  ///< bytes of the list, in the same way
};

/// Reads the end records of a zip archive (APPNOTE.TXT, sections 4.3.14 to 4.3.16), before libzip allocates memory for
/// what they claim. kInvalid if there is none.
Result<ArchiveEnd> read_archive_end(transport::FileSource& file);

}  // namespace rubicon::networks::knx::project
