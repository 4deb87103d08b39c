#include "transport/machine_sockets.h"

#include <fmt/format.h>
#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "base/scheduler.h"
#include "transport/descriptor_watch.h"

namespace rubicon::transport {

namespace {

/// Connections that wait to be accepted; further ones get kBusy and try again.
constexpr int kWaitingConnections = 128;
/// Of those that wait when many processes start at once.
constexpr int kAcceptedPerTurn = 32;
/// Bytes that one call of the system reads.
constexpr std::size_t kBuffer = std::size_t{64} * 1024;
/// Pause before accepting again after the system had no room for a connection.
constexpr Duration kAcceptPause = std::chrono::milliseconds(100);

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

/// One for all connections of a thread: a process with hundreds of them needs one at a time.
Bytes& read_buffer() {
  thread_local Bytes buffer(kBuffer);
  return buffer;
}

/// A connection; reading may destroy it.
class LocalSocket final : public LocalStream {
 public:
  LocalSocket(OwnDescriptor socket, const WatchDescriptor& watch)
      : socket_(std::move(socket)),
        peer_(peer_of(socket_.get())),
        watch_(watch(socket_.get(), {[this] { read(); }, [this] { make_room(); }})) {}

  base::Lifetime::Watch lifetime() { return lifetime_.watch(); }
  void begin(LocalCallbacks calls) {
    callbacks_ = std::move(calls);
    watch_->await_readable();
  }

  Result<std::size_t> write(ByteView bytes) override;
  std::size_t unread() const override;
  const LocalPeer& peer() const override { return peer_; }

 private:
  void read();
  void lose(int error);
  void make_room() {
    waiting_ = false;
    if (callbacks_.writable) callbacks_.writable();
  }

  OwnDescriptor socket_;
  LocalPeer peer_;
  std::unique_ptr<DescriptorWatch> watch_;  ///< null: the connection ended
  LocalCallbacks callbacks_;
  bool waiting_ = false;           ///< for room
  mutable bool may_hold_ = false;  ///< bytes were written since the system was seen to hold none
  base::Lifetime lifetime_;
};

/// Reads until the system has nothing more, or a turn's share was read. So what arrived while this process was stopped
/// is read before timers run.
void LocalSocket::read() {
  const auto alive = lifetime_.watch();
  auto& buffer = read_buffer();
  for (std::size_t total = 0; total < kMaxRead;) {
    const auto got = ::recv(socket_.get(), buffer.data(), buffer.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) break;
    if (got <= 0) return lose(got == 0 ? ECONNRESET : errno);
    const auto size = static_cast<std::size_t>(got);
    total += size;
    if (callbacks_.received) callbacks_.received(ByteView(buffer).first(size));
    if (alive.ended()) return;
    if (size < buffer.size()) break;  // a stream that has less has no more now
  }
  watch_->await_readable();
}

/// Asks the system only after something was written: a process looks at all its connections each second, and most of
/// them are idle. SIOCOUTQ counts the buffers that hold the bytes too: 700 bytes more for each write (unix(7) does not
/// say).
std::size_t LocalSocket::unread() const {
  if (!watch_ || !may_hold_) return 0;
  int held = 0;
  if (::ioctl(socket_.get(), SIOCOUTQ, &held) != 0) return 0;
  may_hold_ = held > 0;
  return static_cast<std::size_t>(held);
}

Result<std::size_t> LocalSocket::write(ByteView bytes) {
  if (!watch_) return fail(ErrorCode::kUnreachable, "the other process is gone");
  may_hold_ = true;
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto sent = ::send(socket_.get(), bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && errno != EAGAIN)  // reading reports it
      return fail(ErrorCode::kUnreachable, fmt::format("cannot send: {}", std::strerror(errno)));
    if (sent < 0) break;
    done += static_cast<std::size_t>(sent);
  }
  if (done < bytes.size() && !std::exchange(waiting_, true)) watch_->await_room();
  return done;
}

void LocalSocket::lose(int error) {
  watch_.reset();
  const std::string why = error == ECONNRESET ? "the other process is gone" : std::strerror(error);
  if (callbacks_.failed) callbacks_.failed({ErrorCode::kUnreachable, why});
}

class LocalPort final : public LocalListener {
 public:
  LocalPort(OwnDescriptor socket, WatchDescriptor watch, Scheduler& scheduler, LocalAccept accept)
      : socket_(std::move(socket)),
        make_watch_(std::move(watch)),
        scheduler_(scheduler),
        accept_(std::move(accept)),
        watch_(make_watch_(socket_.get(), {[this] { arrived(); }, nullptr})) {
    watch_->await_readable();
  }

 private:
  void arrived() {
    const auto alive = lifetime_.watch();
    for (int taken = 0; taken < kAcceptedPerTurn; ++taken) {
      OwnDescriptor one(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      const bool no_room = one.get() < 0 && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM);
      if (no_room) {
        pause_ = scheduler_.after(kAcceptPause, [this] { watch_->await_readable(); });
        return;
      }
      if (one.get() < 0) break;
      take(std::move(one));
      if (alive.ended()) return;
    }
    watch_->await_readable();
  }

  /// The calls may have destroyed the stream before they are known to it.
  void take(OwnDescriptor one) {
    auto stream = std::make_unique<LocalSocket>(std::move(one), make_watch_);
    auto& taken = *stream;
    const auto alive = taken.lifetime();
    auto calls = accept_(std::move(stream));
    if (!alive.ended()) taken.begin(std::move(calls));
  }

  OwnDescriptor socket_;
  WatchDescriptor make_watch_;
  Scheduler& scheduler_;
  LocalAccept accept_;
  std::unique_ptr<DescriptorWatch> watch_;
  Timer pause_;
  base::Lifetime lifetime_;
};

}  // namespace

Result<std::unique_ptr<LocalStream>> open_local_socket(const WatchDescriptor& watch, const std::string& path,
                                                       LocalCallbacks calls) {
  const auto address = socket_address(path);
  if (!address) return fail(address.error());
  auto socket = make_local_socket();
  if (socket.get() < 0) return fail(trouble_with(path, "open a socket", errno));
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return fail(trouble_with(path, "connect", errno));
  auto stream = std::make_unique<LocalSocket>(std::move(socket), watch);
  stream->begin(std::move(calls));
  return stream;
}

Result<std::unique_ptr<LocalListener>> listen_local_socket(const WatchDescriptor& watch, Scheduler& scheduler,
                                                           const std::string& path, LocalAccept accept) {
  const auto address = socket_address(path);
  if (!address) return fail(address.error());
  auto socket = make_local_socket();
  if (socket.get() < 0) return fail(trouble_with(path, "open a socket", errno));
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return fail(trouble_with(path, "make a socket", errno));
  if (::chmod(path.c_str(), 0660) != 0) return fail(trouble_with(path, "give the socket its permissions", errno));
  if (::listen(socket.get(), kWaitingConnections) != 0) return fail(trouble_with(path, "listen", errno));
  return std::make_unique<LocalPort>(std::move(socket), watch, scheduler, std::move(accept));
}

}  // namespace rubicon::transport
