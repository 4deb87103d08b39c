#include "support/memory/memory_transports.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "support/memory/memory_mqtt.h"
#include "support/memory/memory_worker.h"

namespace rubicon::transport {

namespace {

/// Looks up the file at each call, so that a test may change or remove it while it is read.
class MemoryFile final : public FileSource {
 public:
  MemoryFile(const std::map<std::string, MemoryTransports::File>& files, std::string path)
      : files_(files), path_(std::move(path)) {}

  Result<std::size_t> read(std::span<std::uint8_t> into) override {
    const auto found = files_.find(path_);
    if (found == files_.end()) return fail(ErrorCode::kIo, path_ + ": cannot read: the file is gone");
    const auto& [bytes, fails_at, appending, open_to_all] = found->second;
    if (fails_at && position_ >= *fails_at)
      return fail(ErrorCode::kIo, fmt::format("{}: cannot read at {}: Input/output error", path_, position_));
    const std::uint64_t end = std::min<std::uint64_t>(bytes.size(), fails_at.value_or(bytes.size()));
    const auto count = std::min<std::uint64_t>(into.size(), end - std::min(position_, end));
    std::copy_n(bytes.data() + position_, count, into.data());
    position_ += count;
    return static_cast<std::size_t>(count);
  }

  Result<void> seek(std::uint64_t offset) override {
    position_ = std::min(offset, size());
    return {};
  }

  std::uint64_t size() const override {
    const auto found = files_.find(path_);
    return found == files_.end() ? 0 : found->second.bytes.size();
  }
  bool open_to_all() const override {
    const auto found = files_.find(path_);
    return found != files_.end() && found->second.open_to_all;
  }

 private:
  const std::map<std::string, MemoryTransports::File>& files_;
  std::string path_;
  std::uint64_t position_ = 0;
};

}  // namespace

void MemoryTransports::put(const std::string& path, std::string_view text) {
  const auto bytes = base::as_bytes(text);
  put(path, Bytes(bytes.begin(), bytes.end()));
}

void MemoryTransports::join(MemoryNet& net, std::string address) {
  net_ = &net;
  address_ = std::move(address);
  serial_ = std::make_unique<MemorySerial>(net.scheduler());
}

MemorySerial& MemoryTransports::serial() {
  RUBICON_ASSERT(serial_ != nullptr);
  return *serial_;
}

Result<std::unique_ptr<UdpSocket>> MemoryTransports::open_udp(const UdpOptions& options, UdpCallbacks calls) {
  if (net_ == nullptr) return Transports::open_udp(options, std::move(calls));
  return net_->open_udp(address_, options, std::move(calls));
}

Result<std::unique_ptr<TcpStream>> MemoryTransports::open_tcp(const TcpOptions& options, TcpCallbacks calls) {
  if (net_ == nullptr) return Transports::open_tcp(options, std::move(calls));
  return net_->tcp.open(address_, options, std::move(calls));
}

Result<std::unique_ptr<TcpListener>> MemoryTransports::listen_tcp(const Endpoint& local, TcpAccept accept,
                                                                  ListenerFailed failed) {
  if (net_ == nullptr) return Transports::listen_tcp(local, std::move(accept), std::move(failed));
  return net_->tcp.listen(address_, local, std::move(accept), std::move(failed));
}

Result<std::unique_ptr<ByteStream>> MemoryTransports::open_serial(const SerialOptions& options, StreamCallbacks calls) {
  if (net_ == nullptr) return Transports::open_serial(options, std::move(calls));
  return serial_->open(options, std::move(calls));
}

Result<std::unique_ptr<ByteStream>> MemoryTransports::make_pty(const std::string& link, StreamCallbacks calls) {
  if (net_ == nullptr) return Transports::make_pty(link, std::move(calls));
  if (serial_->is_plugged(link) || has(link))
    return fail(ErrorCode::kDuplicate, link + ": cannot make a link: File exists");
  return serial_->plug(link, std::move(calls));
}

Result<std::unique_ptr<MqttLine>> MemoryTransports::open_mqtt(const MqttOptions& options, MqttCallbacks calls) {
  if (net_ == nullptr) return Transports::open_mqtt(options, std::move(calls));
  return open_memory_mqtt(*net_, options, std::move(calls));
}

std::unique_ptr<Lookup> MemoryTransports::look_up(const std::string& host, LookupDone done) {
  RUBICON_ASSERT(net_ != nullptr);
  return net_->look_up(host, std::move(done));
}

Result<std::unique_ptr<FileSource>> MemoryTransports::open_file(const std::string& path) {
  if (files_.contains(path)) return std::make_unique<MemoryFile>(files_, path);
  const bool is_folder =
      std::any_of(files_.begin(), files_.end(), [&](const auto& file) { return file.first.starts_with(path + '/'); });
  if (is_folder) return fail(ErrorCode::kIo, path + ": is a directory, expected a file");
  return fail(ErrorCode::kNotFound, path + ": cannot open: No such file or directory");
}

Result<std::unique_ptr<Worker>> MemoryTransports::start_worker(const std::string& name) {
  if (!net_) return Transports::start_worker(name);
  return std::make_unique<MemoryWorker>(net_->scheduler());
}

}  // namespace rubicon::transport
