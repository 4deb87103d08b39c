#include "base/own_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

namespace rubicon::base {

namespace {

constexpr mode_t kMode = 0640;

ErrorCode code_of(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
    case EROFS: return ErrorCode::kRefused;
    case ENOENT:
    case ENOTDIR: return ErrorCode::kNotFound;
    default: return ErrorCode::kIo;
  }
}

/// The mode that a file should have: another one than now only if it is ours and others may access it.
std::optional<mode_t> better_mode(int descriptor) {
  struct stat about {};
  if (::fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode) || about.st_uid != ::geteuid()) return {};
  if ((about.st_mode & S_IRWXO) == 0) return {};
  return about.st_mode & kMode;
}

}  // namespace

OwnFile::OwnFile(OwnFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

OwnFile& OwnFile::operator=(OwnFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

OwnFile::~OwnFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

int OwnFile::release() {
  return std::exchange(descriptor_, -1);
}

Result<OwnFile> OwnFile::open(const std::string& path, int flags) {
  if (path.find('\0') != std::string::npos) return fail(ErrorCode::kNotFound, "a path with a zero byte in it");
  OwnFile file(::open(path.c_str(), flags | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode));
  if (file.descriptor_ >= 0) {
    if (const auto mode = better_mode(file.descriptor_)) ::fchmod(file.descriptor_, *mode);
    return file;
  }
  const int error = errno;
  if (error == ELOOP) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is a symbolic link: expected a file, or nothing; name the file itself", path));
  }
  return fail(code_of(error), fmt::format("{}: cannot open for writing: {}", path, std::strerror(error)));
}

void OwnFile::close_to_others(const std::string& path) {
  // O_PATH: closing any other descriptor would end the locks that SQLite has on the file in this process.
  const OwnFile file(::open(path.c_str(), O_PATH | O_CLOEXEC | O_NOFOLLOW));
  if (file.descriptor_ < 0) return;
  const auto mode = better_mode(file.descriptor_);
  // fchmod refuses such a descriptor.
  if (mode) ::chmod(fmt::format("/proc/self/fd/{}", file.descriptor_).c_str(), *mode);
}

Result<void> OwnFile::write(std::string_view bytes, const std::string& path) const {
  while (!bytes.empty()) {
    const auto count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return fail(ErrorCode::kIo,
                  fmt::format("{}: cannot write: {}", path, count < 0 ? std::strerror(errno) : "the disk is full"));
    }
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

std::string whole_path(const std::string& path) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path, error);
  return error ? path : whole.lexically_normal().string();  // the folder of this process is gone
}

}  // namespace rubicon::base
