#include "web/server/listener.h"

#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <cerrno>
#include <utility>

#include "web/server/peer_stream.h"

namespace rubicon::web::server {

namespace {

using boost::asio::ip::tcp;
using listen_error = boost::system::error_code;

constexpr Duration kRoomPause = std::chrono::milliseconds(100);
constexpr unsigned kUserTimeoutMillis = 30'000;
constexpr int kKeepAliveSeconds = 15;

template <class Value>
void set_option(tcp::socket& socket, int level, int option, Value value) {
  ::setsockopt(socket.native_handle(), level, option, &value, sizeof value);
}

/// The system notices a client that vanished without closing (tcp(7)); the connection works without this, too.
void tune(tcp::socket& socket) {
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kUserTimeoutMillis);
  set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, kKeepAliveSeconds);
  set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, kKeepAliveSeconds);
}

std::string text_of(boost::asio::ip::address address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    address = boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6());
  return address.to_string();
}

/// Lives until its last operation ended.
struct WebPort : std::enable_shared_from_this<WebPort> {
  WebPort(boost::asio::io_context& context, Scheduler& s, Listener::Callbacks c)
      : acceptor(context), scheduler(s), calls(std::move(c)) {}

  Result<void> open(const transport::Endpoint& endpoint) {
    listen_error error;
    const auto address = boost::asio::ip::make_address(endpoint.address, error);
    if (error) return fail(ErrorCode::kInvalid, fmt::format("{} is no IP address", endpoint.address));
    acceptor.open(tcp::endpoint(address, endpoint.port).protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind({address, endpoint.port}, error);
    if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
    if (!error) local = {endpoint.address, acceptor.local_endpoint(error).port()};
    if (!error) return next(), Result<void>();
    auto code = ErrorCode::kIo;
    if (error.value() == EADDRINUSE) code = ErrorCode::kBusy;
    if (error.value() == EADDRNOTAVAIL) code = ErrorCode::kInvalid;
    return fail(code, fmt::format("cannot listen on {}: {}", to_string(endpoint), error.message()));
  }

  void next() {
    acceptor.async_accept([self = shared_from_this()](const listen_error& error, tcp::socket socket) {
      if (self->alive) self->arrived(error, std::move(socket));
    });
  }

  void arrived(const listen_error& error, tcp::socket socket) {
    const int code = error.value();
    if (error && (code == EMFILE || code == ENFILE || code == ENOBUFS || code == ENOMEM)) {
      pause = scheduler.after(kRoomPause, [this] { next(); });
      return;
    }
    if (error && (code == EBADF || code == EINVAL || code == ENOTSOCK))
      return calls.failed({ErrorCode::kIo, error.message()});
    if (!error) take(std::move(socket));
    if (alive) next();
  }

  void take(tcp::socket socket) {
    listen_error error;
    const auto from = socket.remote_endpoint(error);
    if (!error) socket.non_blocking(true, error);
    if (error) return;  // closed already
    tune(socket);
    calls.accepted(std::make_unique<PeerStream>(std::move(socket), text_of(from.address()), tls));
  }

  tcp::acceptor acceptor;
  Scheduler& scheduler;
  Listener::Callbacks calls;
  Listener::Context tls;
  transport::Endpoint local;
  Timer pause;
  bool alive = true;
};

class WebListener final : public Listener {
 public:
  explicit WebListener(std::shared_ptr<WebPort> port) : port_(std::move(port)) {}
  ~WebListener() override {
    listen_error ignored;
    port_->alive = false;
    port_->pause.cancel();
    port_->acceptor.close(ignored);
  }
  WebListener(const WebListener&) = delete;
  WebListener& operator=(const WebListener&) = delete;

  transport::Endpoint local() const override { return port_->local; }
  void set_tls(Context context) override { port_->tls = std::move(context); }

 private:
  std::shared_ptr<WebPort> port_;
};

}  // namespace

Result<std::unique_ptr<Listener>> Listener::open(boost::asio::io_context& context, Scheduler& scheduler,
                                                 const transport::Endpoint& local, Callbacks calls) {
  auto port = std::make_shared<WebPort>(context, scheduler, std::move(calls));
  if (auto opened = port->open(local); !opened) return fail(opened.error());
  return std::make_unique<WebListener>(std::move(port));
}

}  // namespace rubicon::web::server
