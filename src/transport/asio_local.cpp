#include "transport/asio_local.h"

#include <fmt/format.h>
#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "transport/own_descriptor.h"

namespace rubicon::transport {

namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// Connections that wait to be accepted; further ones get kBusy and try again.
constexpr int kWaitingConnections = 128;
/// Pause before accepting again after the system had no room for a connection.
constexpr auto kAcceptPause = std::chrono::milliseconds(100);

Error trouble_with(const std::string& path, std::string_view doing, int error) {
  const auto code = error == ENOENT                                       ? ErrorCode::kNotFound
                    : error == ECONNREFUSED                               ? ErrorCode::kUnreachable
                    : error == EAGAIN                                     ? ErrorCode::kBusy
                    : error == EACCES || error == EPERM || error == ELOOP ? ErrorCode::kRefused
                    : error == EADDRINUSE                                 ? ErrorCode::kDuplicate
                                                                          : ErrorCode::kIo;
  return {code, fmt::format("{}: cannot {}: {}", path, doing, std::strerror(error))};
}

Result<sockaddr_un> socket_address(const std::string& path) {
  if (path.size() > kMaxSocketPath)
    return fail(ErrorCode::kInvalid, fmt::format("{}: the path of a socket has at most {} bytes, this one has {}", path,
                                                 kMaxSocketPath, path.size()));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(static_cast<char*>(address.sun_path), path.size());
  return address;
}

OwnDescriptor make_local_socket() {
  return OwnDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

LocalPeer peer_of(int socket) {
  LocalPeer peer;
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) return peer;
  peer.user = who.uid;
  peer.process = who.pid;
  peer.groups.push_back(who.gid);
  socklen_t bytes = 0;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, nullptr, &bytes) == 0 || errno != ERANGE) return peer;
  std::vector<gid_t> others(bytes / sizeof(gid_t));
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, others.data(), &bytes) == 0)
    peer.groups.insert(peer.groups.end(), others.begin(), others.end());
  return peer;
}

/// Lives as long as an operation is pending, which may be longer than the stream.
struct LocalTraffic : std::enable_shared_from_this<LocalTraffic> {
  LocalTraffic(const asio::any_io_executor& executor, int descriptor) : socket(executor, descriptor) {}

  bool going() const { return alive && !lost; }

  void wait_readable() {
    socket.async_wait(asio::posix::descriptor_base::wait_read, [self = shared_from_this()](const error_code& error) {
      if (!error && self->going()) self->read();
    });
  }

  /// What is there, until the system has nothing more or a turn's share was read.
  void read() {
    std::size_t size = 0;
    int error = 0;
    bool ended = false;
    while (size < buffer.size()) {
      const auto got = ::recv(socket.native_handle(), buffer.data() + size, buffer.size() - size, 0);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) error = errno;
      ended = got == 0;
      if (got <= 0) break;
      size += static_cast<std::size_t>(got);
    }
    if (size > 0 && calls.received) calls.received(ByteView(buffer).first(size));
    if (!going()) return;
    if (ended || (error != 0 && error != EAGAIN)) return lose(ended ? ECONNRESET : error);
    if (size == buffer.size() && size < LocalStream::kMaxRead) buffer.resize(2 * size);
    wait_readable();
  }

  Result<std::size_t> write(ByteView bytes) {
    if (lost) return fail(ErrorCode::kUnreachable, "the other process is gone");
    std::size_t done = 0;
    while (done < bytes.size()) {
      const auto sent = ::send(socket.native_handle(), bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0 && errno != EAGAIN)  // reading reports it
        return fail(ErrorCode::kUnreachable, fmt::format("cannot send: {}", std::strerror(errno)));
      if (sent < 0) break;
      done += static_cast<std::size_t>(sent);
    }
    if (done < bytes.size()) wait_writable();
    return done;
  }

  void wait_writable() {
    if (std::exchange(waiting, true)) return;
    socket.async_wait(asio::posix::descriptor_base::wait_write, [self = shared_from_this()](const error_code& error) {
      self->waiting = false;
      if (!error && self->going() && self->calls.writable) self->calls.writable();
    });
  }

  void lose(int error) {
    lost = true;
    close();
    const std::string why = error == ECONNRESET ? "the other process is gone" : std::strerror(error);
    if (calls.failed) calls.failed({ErrorCode::kUnreachable, why});
  }

  void close() {
    error_code ignored;
    socket.close(ignored);
  }

  asio::posix::stream_descriptor socket;
  LocalCalls calls;
  LocalPeer peer;
  Bytes buffer = Bytes(8192);
  bool alive = true, lost = false, waiting = false;
};

class AsioLocal final : public LocalStream {
 public:
  explicit AsioLocal(std::shared_ptr<LocalTraffic> traffic) : traffic_(std::move(traffic)) {}
  ~AsioLocal() override {
    traffic_->alive = false;
    traffic_->close();
  }
  AsioLocal(const AsioLocal&) = delete;
  AsioLocal& operator=(const AsioLocal&) = delete;

  Result<std::size_t> write(ByteView bytes) override { return traffic_->write(bytes); }
  /// SIOCOUTQ counts the buffers that hold them too: a little more than the bytes (unix(7) does not say).
  std::size_t unread() const override {
    int held = 0;
    if (traffic_->lost || ::ioctl(traffic_->socket.native_handle(), SIOCOUTQ, &held) != 0) return 0;
    return static_cast<std::size_t>(held);
  }
  const LocalPeer& peer() const override { return traffic_->peer; }

 private:
  std::shared_ptr<LocalTraffic> traffic_;
};

/// Lives as long as an operation is pending, which may be longer than the listener.
struct LocalPort : std::enable_shared_from_this<LocalPort> {
  LocalPort(const asio::any_io_executor& executor, int descriptor, LocalAccept a)
      : socket(executor, descriptor), pause(executor), accept(std::move(a)) {}

  void wait() {
    socket.async_wait(asio::posix::descriptor_base::wait_read, [self = shared_from_this()](const error_code& error) {
      if (!error && self->alive) self->arrived();
    });
  }

  void arrived() {
    OwnDescriptor one(::accept4(socket.native_handle(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    const bool no_room = one.get() < 0 && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM);
    if (no_room) {
      pause.expires_after(kAcceptPause);
      return pause.async_wait([self = shared_from_this()](const error_code&) {
        if (self->alive) self->wait();
      });
    }
    if (one.get() >= 0) take(std::move(one));
    if (alive) wait();
  }

  void take(OwnDescriptor one) {
    auto traffic = std::make_shared<LocalTraffic>(socket.get_executor(), one.get());
    one.take();
    traffic->peer = peer_of(traffic->socket.native_handle());
    auto calls = accept(std::make_unique<AsioLocal>(traffic));
    traffic->calls = std::move(calls);
    if (traffic->going()) traffic->wait_readable();
  }

  void close() {
    error_code ignored;
    alive = false;
    socket.close(ignored);
    pause.cancel();
  }

  asio::posix::stream_descriptor socket;
  asio::steady_timer pause;
  LocalAccept accept;
  bool alive = true;
};

class AsioLocalListener final : public LocalListener {
 public:
  explicit AsioLocalListener(std::shared_ptr<LocalPort> port) : port_(std::move(port)) {}
  ~AsioLocalListener() override { port_->close(); }
  AsioLocalListener(const AsioLocalListener&) = delete;
  AsioLocalListener& operator=(const AsioLocalListener&) = delete;

 private:
  std::shared_ptr<LocalPort> port_;
};

}  // namespace

Result<std::unique_ptr<LocalStream>> connect_asio_local(const asio::any_io_executor& executor, const std::string& path,
                                                        LocalCalls calls) {
  const auto address = socket_address(path);
  if (!address) return fail(address.error());
  auto socket = make_local_socket();
  if (socket.get() < 0) return fail(trouble_with(path, "open a socket", errno));
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return fail(trouble_with(path, "connect", errno));
  auto traffic = std::make_shared<LocalTraffic>(executor, socket.get());
  socket.take();
  traffic->peer = peer_of(traffic->socket.native_handle());
  traffic->calls = std::move(calls);
  // Reading begins in a later turn, so that no call comes before the caller has the stream.
  traffic->wait_readable();
  return std::make_unique<AsioLocal>(std::move(traffic));
}

Result<std::unique_ptr<LocalListener>> listen_asio_local(const asio::any_io_executor& executor, const std::string& path,
                                                         LocalAccept accept) {
  const auto address = socket_address(path);
  if (!address) return fail(address.error());
  auto socket = make_local_socket();
  if (socket.get() < 0) return fail(trouble_with(path, "open a socket", errno));
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return fail(trouble_with(path, "make a socket", errno));
  if (::chmod(path.c_str(), 0660) != 0) return fail(trouble_with(path, "give the socket its permissions", errno));
  if (::listen(socket.get(), kWaitingConnections) != 0) return fail(trouble_with(path, "listen", errno));
  auto port = std::make_shared<LocalPort>(executor, socket.get(), std::move(accept));
  socket.take();
  port->wait();
  return std::make_unique<AsioLocalListener>(std::move(port));
}

}  // namespace rubicon::transport
