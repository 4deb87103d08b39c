#include "transport/local_transports.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace rubicon::transport {

namespace {

tl::unexpected<Error> failed(std::string_view what, const std::string& path) {
  const auto code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
  return fail(code, fmt::format("{} {}: {}", what, path, std::strerror(errno)));
}

class LocalFile final : public FileSource {
 public:
  LocalFile(int descriptor, std::string path, std::uint64_t size)
      : descriptor_(descriptor), path_(std::move(path)), size_(size) {}
  ~LocalFile() override { ::close(descriptor_); }
  LocalFile(const LocalFile&) = delete;
  LocalFile& operator=(const LocalFile&) = delete;

  Result<std::size_t> read(std::span<std::uint8_t> into) override {
    ssize_t count = 0;
    do {
      count = ::read(descriptor_, into.data(), into.size());
    } while (count < 0 && errno == EINTR);
    if (count < 0) return failed("reading", path_);
    return static_cast<std::size_t>(count);
  }

  Result<void> seek(std::uint64_t offset) override {
    if (::lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) return failed("seeking in", path_);
    return {};
  }

  std::uint64_t size() const override { return size_; }

 private:
  int descriptor_;
  std::string path_;
  std::uint64_t size_;
};

}  // namespace

Result<std::unique_ptr<FileSource>> LocalTransports::open_file(const std::string& path) {
  // O_NONBLOCK: opening a FIFO nobody writes to must not stop the loop.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return failed("opening", path);
  struct stat about {};
  if (::fstat(descriptor, &about) < 0 || !S_ISREG(about.st_mode)) {
    ::close(descriptor);
    return fail(ErrorCode::kIo, fmt::format("opening {}: not a regular file", path));
  }
  return std::make_unique<LocalFile>(descriptor, path, static_cast<std::uint64_t>(about.st_size));
}

}  // namespace rubicon::transport
