#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <system_error>

#include "base/own_file.h"
#include "transport/local_transports.h"

namespace rubicon::transport {

namespace {

namespace fs = std::filesystem;

auto refused(const std::string& path, std::string_view doing, std::error_code why) {
  const auto code = why == std::errc::no_such_file_or_directory ? ErrorCode::kNotFound : ErrorCode::kIo;
  return fail(code, fmt::format("{}: cannot {}: {}", path, doing, why.message()));
}

auto refused(const std::string& path, std::string_view doing) {
  return refused(path, doing, std::error_code(errno, std::generic_category()));
}

class LocalAppendFile final : public AppendFile {
 public:
  LocalAppendFile(OwnFile file, std::string path)
      : file_(std::move(file)), descriptor_(file_.get()), path_(std::move(path)) {}

  Result<void> examine() {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) return refused(path_, "examine");
    if (!S_ISREG(status.st_mode)) return fail(ErrorCode::kIo, path_ + ": is not a regular file");
    size_ = static_cast<std::uint64_t>(status.st_size);
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return {};
    if (errno != EWOULDBLOCK) return refused(path_, "lock");
    return fail(ErrorCode::kBusy, path_ + ": another program is writing to it");
  }

  Result<void> append(ByteView bytes) override {
    while (!bytes.empty()) {
      const auto count = ::write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return refused(path_, "write");
      if (count == 0) return fail(ErrorCode::kIo, path_ + ": cannot write: the disk is full");
      size_ += static_cast<std::uint64_t>(count);
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return {};
  }

  std::uint64_t size() const override { return size_; }

  Result<void> truncate(std::uint64_t size) override {
    if (size > static_cast<std::uint64_t>(std::numeric_limits<off_t>::max()))
      return fail(ErrorCode::kOutOfRange, fmt::format("{}: cannot cut at {}", path_, size));
    if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) return refused(path_, "cut");
    size_ = size;
    return {};
  }

 private:
  OwnFile file_;
  int descriptor_;
  std::string path_;
  std::uint64_t size_ = 0;
};

}  // namespace

Result<std::unique_ptr<AppendFile>> LocalTransports::open_append(const std::string& path) {
  auto opened = OwnFile::open(path, O_WRONLY | O_APPEND | O_NONBLOCK);
  if (!opened) return fail(std::move(opened.error()));
  auto file = std::make_unique<LocalAppendFile>(std::move(*opened), path);
  if (auto sound = file->examine(); !sound) return fail(sound.error());
  return file;
}

Result<void> LocalTransports::rename_file(const std::string& from, const std::string& to) {
  int done = ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE);
  if (done != 0 && (errno == EINVAL || errno == ENOSYS)) {
    // A file system without that operation, such as NFS: link() never replaces an existing name.
    done = ::link(from.c_str(), to.c_str());
    if (done == 0) done = ::unlink(from.c_str());
  }
  if (done == 0) return {};
  if (errno == EEXIST)
    return fail(ErrorCode::kDuplicate, fmt::format("{}: cannot be renamed to {}: that exists already", from, to));
  return refused(from, fmt::format("be called {}", to));
}

Result<void> LocalTransports::remove_file(const std::string& path) {
  std::error_code why;
  if (!fs::remove(path, why) && !why) why = std::make_error_code(std::errc::no_such_file_or_directory);
  if (why) return refused(path, "remove", why);
  return {};
}

Result<std::vector<std::string>> LocalTransports::list_folder(const std::string& path) {
  std::vector<std::string> names;
  std::error_code why, ignored;
  for (fs::directory_iterator entry(path.empty() ? "." : path, why), end; !why && entry != end; entry.increment(why)) {
    if (entry->is_regular_file(ignored)) names.push_back(entry->path().filename().string());
  }
  if (why) return refused(path, "list", why);
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace rubicon::transport
