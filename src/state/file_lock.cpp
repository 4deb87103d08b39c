#include "state/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace rubicon::state {

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<FileLock> FileLock::take(const std::string& path) {
  const auto side = path + "-lock";
  // Opened for reading: a side file that another user made locks as well.
  FileLock lock(::open(side.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644));
  if (lock.descriptor_ < 0) {
    const bool forbidden = errno == EACCES || errno == EROFS || errno == EPERM;
    return fail(forbidden ? ErrorCode::kRefused : ErrorCode::kIo,
                fmt::format("state file {}: making {}: {}", path, side, std::strerror(errno)));
  }
  if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno == EWOULDBLOCK) {
    return fail(ErrorCode::kBusy, fmt::format("state file {}: another process has it open for writing", path));
  }
  return fail(ErrorCode::kIo, fmt::format("state file {}: locking {}: {}", path, side, std::strerror(errno)));
}

}  // namespace rubicon::state
