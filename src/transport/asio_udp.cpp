#include "transport/machine_sockets.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <deque>
#include <optional>
#include <utility>

namespace rubicon::transport {

namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

/// Largest payload of an IPv4 datagram (RFC 768, RFC 791).
constexpr std::size_t kMaxLength = 65507;

auto io_error(std::string_view doing, const Endpoint& what, const error_code& error) {
  const auto code = error == asio::error::address_in_use ? ErrorCode::kBusy : ErrorCode::kIo;
  return fail(code, fmt::format("UDP {}: cannot {}: {}", to_string(what), doing, error.message()));
}

Endpoint endpoint_of(const udp::endpoint& endpoint) {
  auto address = endpoint.address();
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    address = asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  return {address.to_string(), endpoint.port()};
}

/// Whether the error comes from an ICMP message about one datagram; the socket stays usable.
bool concerns_a_datagram(int error) {
  return error == ECONNREFUSED || error == EHOSTUNREACH || error == ENETUNREACH || error == EMSGSIZE ||
         error == EHOSTDOWN || error == ENETDOWN || error == EPROTO || error == ENOPROTOOPT || error == EACCES;
}

/// Lives as long as an operation is pending, which may be longer than the socket.
struct Impl : std::enable_shared_from_this<Impl> {
  Impl(const asio::any_io_executor& executor, UdpCallbacks c, std::size_t largest)
      : socket(executor), calls(std::move(c)), buffer(largest) {}

  Result<void> open(const UdpOptions& options);
  error_code bind(const UdpOptions& options);
  error_code bind_one(const udp::endpoint& endpoint, bool both_families);
  Result<void> set_multicast(const UdpMulticast& multicast);
  Result<void> rejoin();
  void report_soon();
  Result<void> join(const std::string& group, int what);
  Result<void> connect(const Endpoint& wanted);
  const Endpoint& name_of(const udp::endpoint& endpoint);
  std::optional<udp::endpoint> target_of(const Endpoint& to);
  void receive();
  void received(const error_code& error, std::size_t size);
  bool take_error_reports();
  Result<void> send(const Endpoint& to, ByteView bytes);
  std::optional<error_code> try_send(const udp::endpoint& to, ByteView bytes);
  void flush_later();
  void flush();

  udp::socket socket;
  UdpCallbacks calls;
  Bytes buffer;
  udp::endpoint from;
  std::deque<std::pair<udp::endpoint, Bytes>> queue;
  std::uint64_t dropped = 0;
  bool send_failed = false;  ///< a send failed because of an ICMP message: there may be a report
  udp::endpoint named;       ///< endpoint that `name` is the text of
  Endpoint name;
  std::optional<udp::endpoint> target;  ///< endpoint of `target_name`
  Endpoint target_name;
  std::optional<udp::endpoint> remote;  ///< in the socket's address family
  std::vector<std::string> groups;      ///< joined groups
  std::string joined_on;                ///< address of an interface; empty = the default one
  bool reuse = false;
  bool six = false;
  bool alive = true;
};

template <class Value>
error_code set(udp::socket& socket, int level, int option, const Value& value) {
  if (::setsockopt(socket.native_handle(), level, option, &value, sizeof value) == 0) return {};
  return {errno, boost::system::system_category()};
}

error_code Impl::bind_one(const udp::endpoint& endpoint, bool both_families) {
  error_code error;
  socket.open(endpoint.protocol(), error);
  if (error) return error;
  six = endpoint.address().is_v6();
  if (six) socket.set_option(asio::ip::v6_only(!both_families), error);
  // Needed to receive reports of ICMP messages (ip(7), IP_RECVERR).
  set(socket, IPPROTO_IP, IP_RECVERR, 1);
  if (six) set(socket, IPPROTO_IPV6, IPV6_RECVERR, 1);
  if (!error && reuse) error = set(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  if (!error) socket.non_blocking(true, error);
  if (!error) socket.bind(endpoint, error);
  if (error) {
    error_code ignored;
    socket.close(ignored);
  }
  return error;
}

error_code Impl::bind(const UdpOptions& options) {
  const auto& wanted = options.local;
  error_code error;
  if (!wanted.address.empty()) {
    const auto address = asio::ip::make_address(wanted.address, error);
    return error ? error : bind_one({address, wanted.port}, false);
  }
  if (options.multicast) return bind_one({udp::v4(), wanted.port}, false);
  error = bind_one({udp::v6(), wanted.port}, true);
  if (!error || error == asio::error::address_in_use || error == asio::error::access_denied) return error;
  return bind_one({udp::v4(), wanted.port}, false);  // a machine without IPv6
}

Result<void> Impl::open(const UdpOptions& options) {
  reuse = options.reuse_address;
  if (const auto error = bind(options)) return io_error("open", options.local, error);
  if (options.multicast) {
    if (auto done = set_multicast(*options.multicast); !done)
      return fail(done.error().code, fmt::format("UDP {}: {}", to_string(options.local), done.error().text));
  }
  return options.remote ? connect(*options.remote) : Result<void>();
}

auto cannot(const std::string& doing, const error_code& error) {
  return fail(ErrorCode::kIo, fmt::format("cannot {}: {}", doing, error.message()));
}

Result<void> Impl::set_multicast(const UdpMulticast& multicast) {
  if (six) return fail(ErrorCode::kUnsupported, "groups are heard on IPv4 sockets only");
  in_addr interface_address{};
  if (!multicast.interface_address.empty()) {
    if (::inet_pton(AF_INET, multicast.interface_address.c_str(), &interface_address) != 1)
      return fail(ErrorCode::kInvalid,
                  fmt::format("'{}' is no IPv4 address of an interface", multicast.interface_address));
    if (const auto error = set(socket, IPPROTO_IP, IP_MULTICAST_IF, interface_address))
      return cannot("send to groups from the interface of " + multicast.interface_address, error);
  }
  // Otherwise it receives all groups that any program on this machine joined (ip(7), IP_MULTICAST_ALL).
  if (const auto error = set(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0)) return cannot("hear own groups only", error);
  if (const auto error = set(socket, IPPROTO_IP, IP_MULTICAST_TTL, static_cast<int>(multicast.ttl)))
    return cannot(fmt::format("set the time to live to {}", multicast.ttl), error);
  if (const auto error = set(socket, IPPROTO_IP, IP_MULTICAST_LOOP, multicast.loopback ? 1 : 0))
    return cannot("set the loopback of groups", error);
  groups = multicast.groups;
  joined_on = multicast.interface_address;
  for (const auto& group : groups) {
    if (auto joined = join(group, IP_ADD_MEMBERSHIP); !joined) return joined;
  }
  return {};
}

/// Joins or leaves a group: `what` is IP_ADD_MEMBERSHIP or IP_DROP_MEMBERSHIP.
Result<void> Impl::join(const std::string& group, int what) {
  ip_mreq wanted{};
  if (!joined_on.empty()) ::inet_pton(AF_INET, joined_on.c_str(), &wanted.imr_interface);
  const bool numeric = ::inet_pton(AF_INET, group.c_str(), &wanted.imr_multiaddr) == 1;
  const error_code error = numeric ? set(socket, IPPROTO_IP, what, wanted) : asio::error::invalid_argument;
  if (!error) return {};
  const auto* where = joined_on.empty() ? "the default interface" : joined_on.c_str();
  return cannot(fmt::format("join group {} on {}", group, where), error);
}

/// The system sends a report only when the last member leaves or the first one joins, hence the leaving.
Result<void> Impl::rejoin() {
  for (const auto& group : groups) {
    (void)join(group, IP_DROP_MEMBERSHIP);  // may fail if the interface changed
    if (auto joined = join(group, IP_ADD_MEMBERSHIP); !joined) return joined;
  }
  return {};
}

Result<void> Impl::connect(const Endpoint& wanted) {
  error_code error;
  auto address = asio::ip::make_address(wanted.address, error);
  if (error || wanted.port == 0)
    return fail(ErrorCode::kInvalid, fmt::format("UDP: no endpoint: {}", to_string(wanted)));
  if (six && address.is_v4()) address = asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4());
  remote.emplace(address, wanted.port);
  socket.connect(*remote, error);
  return error ? Result<void>(io_error("connect", wanted, error)) : Result<void>();
}

/// Cached, because most datagrams come from the same endpoint as the last one.
const Endpoint& Impl::name_of(const udp::endpoint& endpoint) {
  if (endpoint != named) {
    named = endpoint;
    name = endpoint_of(endpoint);
  }
  return name;
}

/// Cached, because most datagrams go to the same endpoint as the last one.
std::optional<udp::endpoint> Impl::target_of(const Endpoint& to) {
  if (target && to == target_name) return target;
  error_code error;
  auto address = asio::ip::make_address(to.address, error);
  if (error || to.port == 0) return std::nullopt;
  if (six && address.is_v4()) address = asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4());
  target.emplace(address, to.port);
  target_name = to;
  return target;
}

void Impl::receive() {
  socket.async_receive_from(asio::buffer(buffer), from, [self = shared_from_this()](auto error, std::size_t size) {
    if (self->alive) self->received(error, size);
  });
}

void Impl::received(const error_code& error, std::size_t size) {
  // Only after an error, because the check costs a system call.
  const bool reports = (error || std::exchange(send_failed, false)) && take_error_reports();
  if (!alive) return;
  if (!error) {
    // Between bind() and connect() a datagram of another endpoint may have arrived.
    if (!remote || from == *remote) calls.received(name_of(from), ByteView(buffer).first(size));
  } else if (!reports && !concerns_a_datagram(error.value())) {
    return calls.failed({ErrorCode::kIo, fmt::format("UDP: cannot receive: {}", error.message())});
  }
  if (alive) receive();
}

/// Empties the socket's queue of ICMP messages (ip(7), MSG_ERRQUEUE); true if there was one.
bool Impl::take_error_reports() {
  bool some = false;
  for (int count = 0; alive && count < 100; ++count) {
    sockaddr_storage address{};
    std::array<char, 512> control{};
    msghdr message{};
    message.msg_name = &address;
    message.msg_namelen = sizeof address;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (::recvmsg(socket.native_handle(), &message, MSG_ERRQUEUE | MSG_DONTWAIT) < 0) return some;
    some = true;
    udp::endpoint to;
    if (message.msg_namelen > to.capacity()) continue;
    std::copy_n(reinterpret_cast<const char*>(&address), message.msg_namelen, reinterpret_cast<char*>(to.data()));
    calls.undelivered(
        {ErrorCode::kUnreachable, fmt::format("UDP {}: the datagram was not delivered", to_string(endpoint_of(to)))});
  }
  return some;
}

/// The failed send took the error from the socket, so that the pending receive does not wake up for the report.
void Impl::report_soon() {
  if (std::exchange(send_failed, true)) return;
  asio::post(socket.get_executor(), [self = shared_from_this()] {
    if (self->alive && std::exchange(self->send_failed, false)) self->take_error_reports();
  });
}

/// nullopt = wait. An ICMP message about an earlier datagram makes one call fail; the next one sends.
std::optional<error_code> Impl::try_send(const udp::endpoint& to, ByteView bytes) {
  error_code error;
  for (int attempt = 0; attempt < 3; ++attempt) {
    socket.send_to(asio::buffer(bytes.data(), bytes.size()), to, 0, error);
    if (!error || !concerns_a_datagram(error.value())) break;
    report_soon();
  }
  if (after_send(error.value()) == AfterSend::kWait) return std::nullopt;
  return error;
}

Result<void> Impl::send(const Endpoint& to, ByteView bytes) {
  if (bytes.size() > kMaxLength) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("UDP {}: {} bytes, at most {} fit", to_string(to), bytes.size(), kMaxLength));
  }
  const auto found = target_of(to);
  if (!found) return fail(ErrorCode::kInvalid, fmt::format("UDP: no endpoint: {}", to_string(to)));
  if (remote && *found != *remote)
    return fail(ErrorCode::kInvalid,
                fmt::format("UDP {}: the socket sends to {} only", to_string(to), to_string(endpoint_of(*remote))));
  if (queue.empty()) {
    const auto done = try_send(*found, bytes);
    if (done && !*done) return {};
    if (done) {
      ++dropped;
      if (after_send(done->value()) == AfterSend::kDrop)
        return fail(ErrorCode::kBusy, fmt::format("UDP {}: dropped, the system has no room for it", to_string(to)));
      return io_error("send", to, *done);
    }
  }
  if (queue.size() >= UdpSocket::kMaxQueued) {
    ++dropped;
    return fail(ErrorCode::kBusy, fmt::format("UDP {}: {} datagrams wait already", to_string(to), queue.size()));
  }
  queue.emplace_back(*found, Bytes(bytes.begin(), bytes.end()));
  if (queue.size() == 1) flush_later();
  return {};
}

void Impl::flush_later() {
  socket.async_wait(udp::socket::wait_write, [self = shared_from_this()](const error_code& error) {
    if (self->alive && !error) self->flush();
  });
}

void Impl::flush() {
  while (!queue.empty()) {
    const auto done = try_send(queue.front().first, queue.front().second);
    if (!done) return flush_later();
    if (*done) ++dropped;
    queue.pop_front();
  }
}

class AsioUdp final : public UdpSocket {
 public:
  explicit AsioUdp(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  ~AsioUdp() override {
    impl_->alive = false;
    error_code ignored;
    impl_->socket.close(ignored);
  }
  AsioUdp(const AsioUdp&) = delete;
  AsioUdp& operator=(const AsioUdp&) = delete;

  Result<void> send(const Endpoint& to, ByteView bytes) override { return impl_->send(to, bytes); }
  Result<void> rejoin() override { return impl_->rejoin(); }
  Endpoint local() const override {
    error_code error;
    const auto bound = impl_->socket.local_endpoint(error);
    return error ? Endpoint{} : endpoint_of(bound);
  }
  std::uint64_t dropped() const override { return impl_->dropped; }

 private:
  std::shared_ptr<Impl> impl_;
};

}  // namespace

AfterSend after_send(int error) {
  if (error == 0) return AfterSend::kSent;
  if (error == EAGAIN) return AfterSend::kWait;
  return error == ENOBUFS ? AfterSend::kDrop : AfterSend::kRefused;
}

Result<std::unique_ptr<UdpSocket>> open_asio_udp(const asio::any_io_executor& executor, const UdpOptions& options,
                                                 UdpCallbacks calls) {
  auto impl = std::make_shared<Impl>(executor, std::move(calls), options.largest);
  if (auto open = impl->open(options); !open) return fail(open.error());
  impl->receive();
  return std::make_unique<AsioUdp>(std::move(impl));
}

}  // namespace rubicon::transport
