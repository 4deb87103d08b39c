#pragma once

#include <memory>

#include "base/scheduler.h"
#include "transport/transports.h"
#include "tuples/host/folder.h"
#include "tuples/host/places.h"

namespace rubicon::tuples::host {

/// The folder of a space on the disk, `<place>/<space>`; below a shared place `islands/<space>` and
/// `people/<uid>/<space>`. What this process has to make is made, with its owner and permissions checked and never
/// through a symbolic link. kInvalid: the space has no valid name; kRefused: the folder belongs to somebody else, is
/// open to others, or may not be entered; kIo: the file system refuses. Scheduler and transports outlive the folder.
Result<std::unique_ptr<Folder>> open_disk_folder(const Place& place, const std::string& space, Scheduler& scheduler,
                                                 transport::Transports& transports);

}  // namespace rubicon::tuples::host
