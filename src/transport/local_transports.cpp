#include "transport/local_transports.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include "base/assert.h"
#include "base/own_file.h"
#include "transport/asio_scheduler.h"
#include "transport/machine_sockets.h"

namespace rubicon::transport {

namespace {

auto io_error(const std::string& path, std::string_view doing, int error) {
  const auto code = error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
  return fail(code, fmt::format("{}: cannot {}: {}", path, doing, std::generic_category().message(error)));
}

bool is_private(const struct stat& status) {
  const bool root = status.st_uid == 0;
  if (!root && status.st_uid != ::geteuid()) return false;
  const mode_t others = root ? S_IRWXO | S_IWGRP | S_IXGRP : S_IRWXO | S_IRWXG;
  return (status.st_mode & others) == 0;
}

boost::asio::any_io_executor executor(Loop& loop) {
  return loop.context().get_executor();
}

class LocalFile final : public FileSource {
 public:
  LocalFile(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {}
  ~LocalFile() override { ::close(descriptor_); }
  LocalFile(const LocalFile&) = delete;
  LocalFile& operator=(const LocalFile&) = delete;

  Result<void> examine() {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) return io_error(path_, "examine", errno);
    if (S_ISDIR(status.st_mode)) return fail(ErrorCode::kIo, path_ + ": is a directory, expected a file");
    if (!S_ISREG(status.st_mode)) return fail(ErrorCode::kIo, path_ + ": is not a regular file");
    size_ = static_cast<std::uint64_t>(status.st_size);
    open_to_all_ = (status.st_mode & S_IROTH) != 0;
    open_to_others_ = !is_private(status);
    return {};
  }

  Result<std::size_t> read(std::span<std::uint8_t> into) override {
    for (;;) {
      const auto count = ::read(descriptor_, into.data(), into.size());
      if (count >= 0) return static_cast<std::size_t>(count);
      if (errno != EINTR) return io_error(path_, "read", errno);
    }
  }

  Result<void> seek(std::uint64_t offset) override {
    if (offset > static_cast<std::uint64_t>(std::numeric_limits<off_t>::max()))
      return fail(ErrorCode::kOutOfRange, fmt::format("{}: cannot seek to {}", path_, offset));
    if (::lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) return io_error(path_, "seek", errno);
    return {};
  }

  std::uint64_t size() const override { return size_; }
  bool open_to_all() const override { return open_to_all_; }
  bool open_to_others() const override { return open_to_others_; }

 private:
  int descriptor_;
  std::string path_;
  std::uint64_t size_ = 0;
  bool open_to_all_ = false, open_to_others_ = false;
};

}  // namespace

LocalTransports::LocalTransports() = default;
LocalTransports::LocalTransports(Loop& loop) : loop_(&loop), names_(std::make_unique<NameLookup>(executor(loop))) {}
LocalTransports::~LocalTransports() = default;

Result<std::unique_ptr<UdpSocket>> LocalTransports::open_udp(const UdpOptions& options, UdpCallbacks calls) {
  if (loop_ == nullptr) return Transports::open_udp(options, std::move(calls));
  return open_asio_udp(executor(*loop_), options, std::move(calls));
}

Result<std::unique_ptr<TcpStream>> LocalTransports::open_tcp(const TcpOptions& options, TcpCallbacks calls) {
  if (loop_ == nullptr) return Transports::open_tcp(options, std::move(calls));
  return open_asio_tcp(executor(*loop_), options, std::move(calls));
}

Result<std::unique_ptr<TcpListener>> LocalTransports::listen_tcp(const Endpoint& local, TcpAccept accept,
                                                                 ListenerFailed failed) {
  if (loop_ == nullptr) return Transports::listen_tcp(local, std::move(accept), std::move(failed));
  return listen_asio_tcp(executor(*loop_), local, std::move(accept), std::move(failed));
}

Result<std::unique_ptr<LocalStream>> LocalTransports::open_local(const std::string& path, LocalCallbacks calls) {
  if (loop_ == nullptr) return Transports::open_local(path, std::move(calls));
  return open_local_socket(asio_watch(executor(*loop_)), path, std::move(calls));
}

Result<std::unique_ptr<LocalListener>> LocalTransports::listen_local(const std::string& path, LocalAccept accept) {
  if (loop_ == nullptr) return Transports::listen_local(path, std::move(accept));
  return listen_local_socket(asio_watch(executor(*loop_)), loop_->scheduler(), path, std::move(accept));
}

Result<std::unique_ptr<ByteStream>> LocalTransports::open_serial(const SerialOptions& options, StreamCallbacks calls) {
  if (loop_ == nullptr) return Transports::open_serial(options, std::move(calls));
  return open_asio_serial(executor(*loop_), options, std::move(calls));
}

Result<std::unique_ptr<ByteStream>> LocalTransports::make_pty(const std::string& link, StreamCallbacks calls) {
  if (loop_ == nullptr) return Transports::make_pty(link, std::move(calls));
  return make_asio_pty(executor(*loop_), link, std::move(calls));
}

Result<std::unique_ptr<MqttLine>> LocalTransports::open_mqtt(const MqttOptions& options, MqttCallbacks calls) {
  if (loop_ == nullptr) return Transports::open_mqtt(options, std::move(calls));
  if (!mqtt_) mqtt_ = std::make_unique<MosquittoLines>(loop_->scheduler());
  return mqtt_->open(options, std::move(calls));
}

std::unique_ptr<Lookup> LocalTransports::look_up(const std::string& host, LookupDone done) {
  RUBICON_ASSERT(names_ != nullptr);
  return names_->look_up(host, std::move(done));
}

Result<std::unique_ptr<FileSource>> LocalTransports::open_file(const std::string& path) {
  if (path.find('\0') != std::string::npos) return fail(ErrorCode::kNotFound, "a path with a zero byte in it");
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return io_error(path, "open", errno);
  auto file = std::make_unique<LocalFile>(descriptor, path);
  if (auto sound = file->examine(); !sound) return fail(sound.error());
  return file;
}

Result<std::unique_ptr<Worker>> LocalTransports::start_worker(const std::string& name) {
  return transport::start_worker(name);
}

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
