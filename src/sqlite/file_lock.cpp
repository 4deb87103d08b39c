#include "sqlite/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace rubicon::sqlite {

Result<FileLock> FileLock::take(const char* noun, const std::string& path) {
  const auto side = path + "-lock";
  // Reading is enough to lock, also a file that another user created.
  auto opened = OwnFile::open(side, O_RDONLY | O_NONBLOCK);
  if (!opened) {
    const auto code = opened.error().code == ErrorCode::kRefused ? ErrorCode::kRefused : ErrorCode::kIo;
    return fail(code, fmt::format("{} {}: its lock {}", noun, path, opened.error().text));
  }
  FileLock lock(std::move(*opened));
  if (::flock(lock.side_.get(), LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno == EWOULDBLOCK) {
    return fail(ErrorCode::kBusy, fmt::format("{} {}: another process has it open for writing", noun, path));
  }
  return fail(ErrorCode::kIo, fmt::format("{} {}: locking {}: {}", noun, path, side, std::strerror(errno)));
}

}  // namespace rubicon::sqlite
