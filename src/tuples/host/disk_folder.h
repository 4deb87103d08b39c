#pragma once

#include <functional>
#include <memory>

#include "tuples/host/folder.h"
#include "tuples/host/places.h"

namespace rubicon::tuples::host {

/// How sockets are made and reached: transport::listen_asio_local() and connect_asio_local() on the loop.
struct Sockets {
  std::function<Result<std::unique_ptr<transport::LocalListener>>(const std::string& path, transport::LocalAccept)>
      listen;
  std::function<Result<std::unique_ptr<transport::LocalStream>>(const std::string& path, transport::LocalCalls)>
      connect;
};

/// The folder of a space on the disk, `<place>/<space>`; below a shared place `islands/<space>` and
/// `people/<uid>/<space>`. What this process has to make is made, with its owner and permissions checked and never
/// through a symbolic link. kInvalid: the space has no valid name; kRefused: the folder belongs to somebody else, is
/// open to others, or may not be entered; kIo: the file system refuses.
Result<std::unique_ptr<Folder>> open_disk_folder(const Place& place, const std::string& space, Sockets sockets);

}  // namespace rubicon::tuples::host
