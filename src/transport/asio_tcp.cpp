#include "transport/asio_tcp.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <utility>

namespace rubicon::transport {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

Error io_error(std::string_view doing, const Endpoint& what, const error_code& error) {
  return {ErrorCode::kIo, fmt::format("TCP {}: cannot {}: {}", to_string(what), doing, error.message())};
}

/// Lives as long as a call to the kernel is pending, which may be longer than the stream.
struct Parts : std::enable_shared_from_this<Parts> {
  Parts(asio::io_context& context, const TcpOptions& o, TcpCalls c)
      : socket(context), deadline(context), options(o), calls(std::move(c)) {}

  Result<void> open();
  void set_options();
  void connect(const tcp::endpoint& remote);
  void connected_or_not(const error_code& error);
  void receive();
  void received(const error_code& error, std::size_t size);
  void hold(bool hold);
  Result<void> send(ByteView bytes);
  std::size_t write_some(ByteView bytes, error_code& error);
  void flush_later();
  void flush(const error_code& error);
  void lose(Error why);
  void abort();
  void close();

  tcp::socket socket;
  asio::steady_timer deadline;
  TcpOptions options;
  TcpCalls calls;
  std::array<std::uint8_t, 8192> buffer{};
  Bytes queue;  ///< from `written` on
  std::size_t written = 0;
  bool connected = false, lost = false, waiting = false, alive = true, held = false;
  std::size_t kept = 0;  ///< bytes of the buffer that came while held
};

template <class Value>
void set(tcp::socket& socket, int level, int option, Value value) {
  ::setsockopt(socket.native_handle(), level, option, &value, sizeof value);
}

int whole_seconds(Duration span) {
  return static_cast<int>(std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::seconds>(span).count()));
}

/// A system without one of them still has a connection; hence no complaint (tcp(7)).
void Parts::set_options() {
  set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  const auto user = std::chrono::ceil<std::chrono::milliseconds>(options.user_timeout).count();
  if (user > 0) set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<unsigned>(user));
  if (options.keep_alive <= Duration::zero()) return;
  set(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(socket, IPPROTO_TCP, TCP_KEEPIDLE, whole_seconds(options.keep_alive));
  set(socket, IPPROTO_TCP, TCP_KEEPINTVL, whole_seconds(options.keep_alive));
  if (user > 0)
    set(socket, IPPROTO_TCP, TCP_KEEPCNT,
        std::max(1, whole_seconds(options.user_timeout / options.keep_alive * std::chrono::seconds(1))));
}

Result<void> Parts::open() {
  error_code error;
  const auto address = asio::ip::make_address(options.remote.address, error);
  if (error || options.remote.port == 0)
    return fail(ErrorCode::kInvalid, fmt::format("TCP: no endpoint: {}", to_string(options.remote)));
  const tcp::endpoint remote(address, options.remote.port);
  socket.open(remote.protocol(), error);
  if (!error) socket.non_blocking(true, error);
  if (error) return fail(io_error("open a socket", options.remote, error));
  set_options();
  connect(remote);
  return {};
}

void Parts::connect(const tcp::endpoint& remote) {
  socket.async_connect(remote, [self = shared_from_this()](const error_code& error) {
    if (self->alive && !self->lost) self->connected_or_not(error);
  });
  deadline.expires_after(options.connect_timeout);
  deadline.async_wait([self = shared_from_this()](const error_code& error) {
    if (error || !self->alive || self->lost || self->connected) return;
    const auto waited = std::chrono::duration<double>(self->options.connect_timeout).count();
    self->lose({ErrorCode::kUnreachable,
                fmt::format("TCP {}: cannot connect: no answer within {} s", to_string(self->options.remote), waited)});
  });
}

void Parts::connected_or_not(const error_code& error) {
  if (error) {
    auto why = io_error("connect", options.remote, error);
    why.code = ErrorCode::kUnreachable;
    return lose(std::move(why));
  }
  connected = true;
  deadline.cancel();
  receive();
  if (!queue.empty()) flush({});
  if (alive && !lost && calls.connected) calls.connected();
}

void Parts::receive() {
  socket.async_read_some(asio::buffer(buffer), [self = shared_from_this()](const error_code& error, std::size_t size) {
    if (self->alive && !self->lost) self->received(error, size);
  });
}

void Parts::received(const error_code& error, std::size_t size) {
  if (error == asio::error::eof)
    return lose({ErrorCode::kUnreachable, fmt::format("TCP {}: the other end closed", to_string(options.remote))});
  if (error) return lose(io_error("receive", options.remote, error));
  if (held) return void(kept = size);
  calls.received(ByteView(buffer).first(size));
  if (alive && !lost) receive();
}

/// One read is always under way, or its bytes are kept: so little is taken from the system while held.
void Parts::hold(bool hold) {
  if (std::exchange(held, hold) == hold || hold || kept == 0) return;
  asio::post(socket.get_executor(), [self = shared_from_this()] {
    if (self->alive && !self->lost && !self->held && self->kept > 0) self->received({}, std::exchange(self->kept, 0));
  });
}

/// As much as the system takes at once.
std::size_t Parts::write_some(ByteView bytes, error_code& error) {
  std::size_t done = 0;
  while (done < bytes.size() && !error)
    done += socket.write_some(asio::buffer(bytes.data() + done, bytes.size() - done), error);
  if (error == asio::error::would_block || error == asio::error::try_again) error = {};
  return done;
}

Result<void> Parts::send(ByteView bytes) {
  const auto name = to_string(options.remote);
  if (lost) return fail(ErrorCode::kUnreachable, fmt::format("TCP {}: cannot send: the connection is lost", name));
  const auto waits = queue.size() - written;
  if (waits + bytes.size() > TcpStream::kMaxQueued)
    return fail(ErrorCode::kBusy,
                fmt::format("TCP {}: cannot send {} bytes: {} wait already", name, bytes.size(), waits));
  error_code error;
  const auto done = connected && waits == 0 ? write_some(bytes, error) : 0;
  // A broken connection shows itself in a later turn, when it is received from.
  if (error) return fail(ErrorCode::kUnreachable, io_error("send", options.remote, error).text);
  queue.insert(queue.end(), bytes.begin() + static_cast<std::ptrdiff_t>(done), bytes.end());
  if (connected && !queue.empty()) flush_later();
  return {};
}

void Parts::flush_later() {
  if (std::exchange(waiting, true)) return;
  socket.async_wait(tcp::socket::wait_write, [self = shared_from_this()](const error_code& error) {
    self->waiting = false;
    if (self->alive && !self->lost) self->flush(error);
  });
}

void Parts::flush(const error_code& waited) {
  error_code error = waited;
  if (!error) written += write_some(ByteView(queue).subspan(written), error);
  if (error) return lose(io_error("send", options.remote, error));
  queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(std::exchange(written, 0)));
  if (!queue.empty()) flush_later();
}

void Parts::close() {
  error_code ignored;
  deadline.cancel();
  socket.close(ignored);
}

/// Closed with a linger time of 0 it is reset, and what it still had to send is thrown away (socket(7), SO_LINGER).
void Parts::abort() {
  if (socket.is_open()) set(socket, SOL_SOCKET, SO_LINGER, ::linger{1, 0});
  lost = true;
  connected = false;
  queue.clear();
  close();
}

void Parts::lose(Error why) {
  lost = true;
  connected = false;
  queue.clear();
  close();
  calls.failed(std::move(why));
}

class AsioTcp final : public TcpStream {
 public:
  explicit AsioTcp(std::shared_ptr<Parts> parts) : parts_(std::move(parts)) {}
  ~AsioTcp() override {
    parts_->alive = false;
    parts_->close();
  }
  AsioTcp(const AsioTcp&) = delete;
  AsioTcp& operator=(const AsioTcp&) = delete;

  Result<void> send(ByteView bytes) override { return parts_->send(bytes); }
  void abort() override { parts_->abort(); }
  void hold(bool held) override { parts_->hold(held); }
  std::size_t queued() const override { return parts_->queue.size() - parts_->written; }
  bool connected() const override { return parts_->connected; }
  Endpoint local() const override {
    error_code error;
    const auto bound = parts_->connected ? parts_->socket.local_endpoint(error) : tcp::endpoint();
    if (error || bound.port() == 0) return {};
    return {bound.address().to_string(), bound.port()};
  }
  Endpoint remote() const override { return parts_->connected ? parts_->options.remote : Endpoint{}; }

 private:
  std::shared_ptr<Parts> parts_;
};

}  // namespace

Result<std::unique_ptr<TcpStream>> open_asio_tcp(asio::io_context& context, const TcpOptions& options, TcpCalls calls) {
  auto parts = std::make_shared<Parts>(context, options, std::move(calls));
  if (auto open = parts->open(); !open) return fail(open.error());
  return std::make_unique<AsioTcp>(std::move(parts));
}

}  // namespace rubicon::transport
