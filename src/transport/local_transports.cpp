#include "transport/local_transports.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <limits>
#include <system_error>
#include <utility>

#include "base/assert.h"
#include "transport/asio_scheduler.h"
#include "transport/asio_serial.h"
#include "transport/asio_tcp.h"
#include "transport/asio_udp.h"
#include "transport/asio_watch.h"
#include "transport/local_sockets.h"
#include "transport/mosquitto_line.h"
#include "transport/name_lookup.h"

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

Result<std::unique_ptr<UdpSocket>> LocalTransports::open_udp(const UdpOptions& options, UdpCalls calls) {
  if (loop_ == nullptr) return Transports::open_udp(options, std::move(calls));
  return open_asio_udp(executor(*loop_), options, std::move(calls));
}

Result<std::unique_ptr<TcpStream>> LocalTransports::open_tcp(const TcpOptions& options, TcpCalls calls) {
  if (loop_ == nullptr) return Transports::open_tcp(options, std::move(calls));
  return open_asio_tcp(executor(*loop_), options, std::move(calls));
}

Result<std::unique_ptr<TcpListener>> LocalTransports::listen_tcp(const Endpoint& local, TcpAccept accept,
                                                                 ListenerFailed failed) {
  if (loop_ == nullptr) return Transports::listen_tcp(local, std::move(accept), std::move(failed));
  return listen_asio_tcp(executor(*loop_), local, std::move(accept), std::move(failed));
}

Result<std::unique_ptr<LocalStream>> LocalTransports::open_local(const std::string& path, LocalCalls calls) {
  if (loop_ == nullptr) return Transports::open_local(path, std::move(calls));
  return open_local_socket(asio_watch(executor(*loop_)), path, std::move(calls));
}

Result<std::unique_ptr<LocalListener>> LocalTransports::listen_local(const std::string& path, LocalAccept accept) {
  if (loop_ == nullptr) return Transports::listen_local(path, std::move(accept));
  return listen_local_socket(asio_watch(executor(*loop_)), loop_->scheduler(), path, std::move(accept));
}

Result<std::unique_ptr<ByteStream>> LocalTransports::open_serial(const SerialOptions& options, StreamCalls calls) {
  if (loop_ == nullptr) return Transports::open_serial(options, std::move(calls));
  return open_asio_serial(executor(*loop_), options, std::move(calls));
}

Result<std::unique_ptr<ByteStream>> LocalTransports::make_pty(const std::string& link, StreamCalls calls) {
  if (loop_ == nullptr) return Transports::make_pty(link, std::move(calls));
  return make_asio_pty(executor(*loop_), link, std::move(calls));
}

Result<std::unique_ptr<MqttLine>> LocalTransports::open_mqtt(const MqttOptions& options, MqttCalls calls) {
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

}  // namespace rubicon::transport
