#include "transport/machine_sockets.h"

#include <fmt/format.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <utility>

#include "transport/asio_traffic.h"

namespace rubicon::transport {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

std::string name_of(const Endpoint& endpoint) {
  return "TCP " + to_string(endpoint);
}

/// A connection that is being established, or established.
struct Connection final : AsioTraffic<tcp::socket> {
  Connection(const asio::any_io_executor& executor, const TcpOptions& o, TcpCallbacks c)
      : AsioTraffic(executor, name_of(o.remote), "the other end closed", std::move(c)),
        deadline(executor),
        options(o) {}

  std::shared_ptr<Connection> self() { return std::static_pointer_cast<Connection>(shared_from_this()); }
  Result<void> open();
  void set_options();
  void connect(const tcp::endpoint& remote);
  void connected_or_not(const error_code& error);
  std::size_t unacknowledged();
  void abort();

  asio::steady_timer deadline;
  TcpOptions options;
};

template <class Value>
void set(tcp::socket& socket, int level, int option, Value value) {
  ::setsockopt(socket.native_handle(), level, option, &value, sizeof value);
}

int whole_seconds(Duration span) {
  return static_cast<int>(std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::seconds>(span).count()));
}

/// Errors are ignored: the connection also works without these options (tcp(7)).
void Connection::set_options() {
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

Result<void> Connection::open() {
  error_code error;
  const auto address = asio::ip::make_address(options.remote.address, error);
  if (error || options.remote.port == 0)
    return fail(ErrorCode::kInvalid, fmt::format("TCP: no endpoint: {}", to_string(options.remote)));
  const tcp::endpoint remote(address, options.remote.port);
  socket.open(remote.protocol(), error);
  if (!error) socket.non_blocking(true, error);
  if (error) return fail(trouble("open a socket", error));
  set_options();
  connect(remote);
  return {};
}

void Connection::connect(const tcp::endpoint& remote) {
  socket.async_connect(remote, [me = self()](const error_code& error) {
    if (me->going()) me->connected_or_not(error);
  });
  deadline.expires_after(options.connect_timeout);
  deadline.async_wait([me = self()](const error_code& error) {
    if (error || !me->going() || me->connected) return;
    const auto waited = std::chrono::duration<double>(me->options.connect_timeout).count();
    me->lose({ErrorCode::kUnreachable, fmt::format("{}: cannot connect: no answer within {} s", me->name, waited)});
  });
}

void Connection::connected_or_not(const error_code& error) {
  deadline.cancel();
  if (!error) return begin();
  auto why = trouble("connect", error);
  why.code = ErrorCode::kUnreachable;
  lose(std::move(why));
}

/// SIOCOUTQ: what the socket holds, sent or not, until it is acknowledged (tcp(7)).
std::size_t Connection::unacknowledged() {
  if (!connected) return waits();
  int held_by_socket = 0;
  if (::ioctl(socket.native_handle(), SIOCOUTQ, &held_by_socket) != 0) held_by_socket = 0;
  return waits() + static_cast<std::size_t>(held_by_socket);
}

/// Closing with a linger time of 0 resets the connection and discards unsent data (socket(7), SO_LINGER).
void Connection::abort() {
  if (socket.is_open()) set(socket, SOL_SOCKET, SO_LINGER, ::linger{1, 0});
  deadline.cancel();
  end();
}

class AsioTcp final : public TcpStream {
 public:
  explicit AsioTcp(std::shared_ptr<Connection> connection) : connection_(std::move(connection)) {}
  ~AsioTcp() override {
    connection_->deadline.cancel();
    connection_->leave();
  }
  AsioTcp(const AsioTcp&) = delete;
  AsioTcp& operator=(const AsioTcp&) = delete;

  Result<void> send(ByteView bytes) override { return connection_->send(bytes); }
  void abort() override { connection_->abort(); }
  void hold(bool held) override { connection_->hold(held); }
  std::size_t queued() const override { return connection_->waits(); }
  bool connected() const override { return connection_->connected; }
  std::size_t unacknowledged() const override { return connection_->unacknowledged(); }
  Endpoint local() const override {
    error_code error;
    const auto bound = connection_->connected ? connection_->socket.local_endpoint(error) : tcp::endpoint();
    if (error || bound.port() == 0) return {};
    return {bound.address().to_string(), bound.port()};
  }
  Endpoint remote() const override { return connection_->connected ? connection_->options.remote : Endpoint{}; }

 private:
  std::shared_ptr<Connection> connection_;
};

/// Whether the error of accept(2) concerns only the connection that was to be accepted.
bool concerns_one_connection(int error) {
  return error == ECONNABORTED || error == EPROTO || error == ENETDOWN || error == ENOPROTOOPT || error == EHOSTDOWN ||
         error == ENONET || error == EHOSTUNREACH || error == EOPNOTSUPP || error == ENETUNREACH || error == EPERM ||
         error == EINTR;
}

bool lacks_room(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

/// Pause before accepting again after the system had no room for a connection.
constexpr auto kRoomPause = std::chrono::milliseconds(100);

struct Port : std::enable_shared_from_this<Port> {
  Port(const asio::any_io_executor& e, Endpoint l, TcpAccept a, ListenerFailed f)
      : acceptor(e), pause(e), local(std::move(l)), accept(std::move(a)), failed(std::move(f)) {}

  Result<void> open();
  error_code bind(const tcp::endpoint& endpoint);
  void next();
  void arrived(const error_code& error, tcp::socket socket);
  void take(tcp::socket socket);

  tcp::acceptor acceptor;
  asio::steady_timer pause;
  Endpoint local;
  TcpAccept accept;
  ListenerFailed failed;
  bool alive = true;
};

error_code Port::bind(const tcp::endpoint& endpoint) {
  error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (!error) local.port = acceptor.local_endpoint(error).port();
  return error;
}

Result<void> Port::open() {
  error_code error;
  const auto address = asio::ip::make_address(local.address, error);
  if (error) return fail(ErrorCode::kInvalid, fmt::format("TCP: no address to listen on: {}", to_string(local)));
  error = bind({address, local.port});
  if (!error) return next(), Result<void>();
  const auto code = error == asio::error::address_in_use ? ErrorCode::kBusy : ErrorCode::kIo;
  return fail(code, fmt::format("{}: cannot listen: {}", name_of(local), error.message()));
}

void Port::next() {
  acceptor.async_accept([self = shared_from_this()](const error_code& error, tcp::socket socket) {
    if (self->alive) self->arrived(error, std::move(socket));
  });
}

void Port::arrived(const error_code& error, tcp::socket socket) {
  if (lacks_room(error.value())) {
    pause.expires_after(kRoomPause);
    return pause.async_wait([self = shared_from_this()](const error_code&) {
      if (self->alive) self->next();
    });
  }
  if (error && !concerns_one_connection(error.value())) {
    error_code ignored;
    acceptor.close(ignored);
    if (failed)
      failed({ErrorCode::kIo, fmt::format("{}: cannot accept connections: {}", name_of(local), error.message())});
    return;
  }
  if (!error) take(std::move(socket));
  if (alive) next();
}

void Port::take(tcp::socket socket) {
  error_code error;
  const auto from = socket.remote_endpoint(error);
  if (!error) socket.non_blocking(true, error);
  if (error) return;  // closed already
  auto address = from.address();
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    address = asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  TcpOptions options;
  options.remote = {address.to_string(), from.port()};
  auto connection = std::make_shared<Connection>(acceptor.get_executor(), options, TcpCallbacks{});
  connection->socket = std::move(socket);
  connection->set_options();
  connection->connected = true;
  auto calls = accept(std::make_unique<AsioTcp>(connection));
  connection->calls = std::move(calls);
  connection->calls.connected = nullptr;
  if (connection->going()) connection->receive();
}

class AsioListener final : public TcpListener {
 public:
  explicit AsioListener(std::shared_ptr<Port> port) : port_(std::move(port)) {}
  ~AsioListener() override {
    error_code ignored;
    port_->alive = false;
    port_->acceptor.close(ignored);
    port_->pause.cancel();
  }
  AsioListener(const AsioListener&) = delete;
  AsioListener& operator=(const AsioListener&) = delete;

  Endpoint local() const override { return port_->local; }

 private:
  std::shared_ptr<Port> port_;
};

}  // namespace

Result<std::unique_ptr<TcpStream>> open_asio_tcp(const asio::any_io_executor& executor, const TcpOptions& options,
                                                 TcpCallbacks calls) {
  auto connection = std::make_shared<Connection>(executor, options, std::move(calls));
  if (auto open = connection->open(); !open) return fail(open.error());
  return std::make_unique<AsioTcp>(std::move(connection));
}

Result<std::unique_ptr<TcpListener>> listen_asio_tcp(const asio::any_io_executor& executor, const Endpoint& local,
                                                     TcpAccept accept, ListenerFailed failed) {
  auto port = std::make_shared<Port>(executor, local, std::move(accept), std::move(failed));
  if (auto open = port->open(); !open) return fail(open.error());
  return std::make_unique<AsioListener>(std::move(port));
}

}  // namespace rubicon::transport
