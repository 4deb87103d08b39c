#pragma once

#include <zip.h>

#include <memory>

#include "base/bytes.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::project {

/// A file as libzip reads it. The source owns the file; nullptr: no memory.
zip_source_t* zip_source_of(std::unique_ptr<transport::FileSource> file, zip_error_t* error);

/// A file whose content is in memory, which is overwritten in the end: it may hold a project with its keys.
std::unique_ptr<transport::FileSource> file_of(Bytes content);

}  // namespace rubicon::networks::knx::project
