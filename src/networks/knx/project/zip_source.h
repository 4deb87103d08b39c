#pragma once

#include <zip.h>

#include <cstdint>
#include <memory>

#include "base/bytes.h"
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

/// A file as libzip reads it. The source owns the file; nullptr: no memory.
zip_source_t* zip_source_of(std::unique_ptr<transport::FileSource> file, zip_error_t* error);

/// A file whose content is in memory, which is overwritten in the end: it may hold a project with its keys.
std::unique_ptr<transport::FileSource> file_of(Bytes content);

}  // namespace rubicon::networks::knx::project
