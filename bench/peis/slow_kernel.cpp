#include "peis/slow_kernel.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <utility>

#include "components/node.h"
#include "frame/running_island.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::bench::peis {

namespace {

using namespace std::chrono_literals;
using namespace tuples::peis;

constexpr OwnerId kKernel{500};
constexpr std::uint32_t kMagic = 77;
constexpr auto kReadStep = 2ms;
constexpr int kPackagesOfStep = 9;

}  // namespace

SlowKernel::SlowKernel(std::string network, std::size_t keys) : network_(std::move(network)), numbers_(keys) {
  connect();
}

SlowKernel::~SlowKernel() {
  if (socket_ >= 0) ::close(socket_);
}

void SlowKernel::connect() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(kFirstListenPort);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  for (int i = 0; i < 1000; ++i) {
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
    ::close(std::exchange(socket_, -1));
    std::this_thread::sleep_for(10ms);
  }
  throw std::runtime_error("no component listens on port 8000");
}

void SlowKernel::send(PackageHeader header, const Bytes& body) {
  header.id = next_id();
  header.ack_id = header.wants_ack() ? next_id() : header.id;
  header.counter = counter_++;
  header.source = kKernel;
  Bytes package;
  append_package(package, header, body);
  if (::send(socket_, package.data(), package.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(package.size()))
    throw std::runtime_error("the component closed the connection");
}

void SlowKernel::send_link(Port port, const Bytes& body) {
  PackageHeader header;
  header.port = port;
  send(header, body);
}

void SlowKernel::send_direct(Port port, const Bytes& body, bool wants_ack) {
  PackageHeader header;
  header.routing = Routing::kDirect;
  header.destination = kFirst;
  header.port = port;
  header.flags = wants_ack ? kFlagWantsAck : 0;
  send(header, body);
}

void SlowKernel::introduce() {
  const auto connect = write(ConnectMessage{kKernel, kForcedByCluster, network_});
  if (::send(socket_, connect.data(), connect.size(), MSG_NOSIGNAL) < 0) throw std::runtime_error("cannot send");
  HostRecord record;
  record.id = record.cluster = kKernel;
  record.magic = kMagic;
  record.host_name = "hostx";
  record.full_name = "reader@hostx!1";
  send_link(Port::kHostInfo, write(HostRecordMessage{record, false}));
  send_link(Port::kRouting, write(RoutingPage{0, 1, 1, {{kKernel, 1, kMagic, 0, 1}}}));
}

void SlowKernel::subscribe(const std::string& key) {
  Subscribe subscribe;
  subscribe.prototype.key = key;
  send_direct(Port::kSubscribe, write(subscribe), true);
}

Json SlowKernel::run() {
  introduce();
  subscribe("bench.done");
  subscribe("*.*.*.*.*.*");
  auto last = Clock::now();
  for (auto next = last; !is_over_ || Clock::now() - last < 1s; next = std::max(next + kReadStep, Clock::now())) {
    std::this_thread::sleep_until(next);
    int waiting = 0;
    ::ioctl(socket_, FIONREAD, &waiting);
    most_waiting_ = std::max(most_waiting_, waiting);
    for (int i = 0; i < kPackagesOfStep && read_package(); ++i) last = Clock::now();
    if (!acks_.empty() && Clock::now() >= next_acks_) acknowledge();
  }
  leave();
  return {{"values", values_}, {"resends", resends_}, {"most_waiting", most_waiting_}, {"numbers", numbers_}};
}

/// False: no whole package is there.
bool SlowKernel::read_package() {
  std::uint8_t bytes[kHeaderSize + kMaxBody];
  int waiting = 0;
  const auto peeked = ::recv(socket_, bytes, kHeaderSize, MSG_PEEK | MSG_DONTWAIT);
  if (peeked == 0) throw std::runtime_error("the component closed the connection");
  if (peeked < static_cast<ssize_t>(kHeaderSize)) return false;
  const auto header = must(read_package_header(ByteView(bytes, kHeaderSize)));
  const auto size = kHeaderSize + header.length;
  ::ioctl(socket_, FIONREAD, &waiting);
  if (static_cast<std::size_t>(waiting) < size) return false;
  if (::recv(socket_, bytes, size, 0) != static_cast<ssize_t>(size)) throw std::runtime_error("cannot receive");
  take({header, ByteView(bytes + kHeaderSize, header.length)});
  return true;
}

void SlowKernel::take(const Package& package) {
  const auto& header = package.header;
  if (header.routing != Routing::kDirect || !header.wants_ack()) return;
  if (acks_.empty()) next_acks_ = Clock::now() + kAckDelay;
  acks_.push_back(header.ack_id);
  if (acks_.size() >= kMaxAcks) acknowledge();
  if (!seen_.insert(header.ack_id).second) return void(++resends_);
  if (header.port == Port::kPush) take_push(package.body);
}

void SlowKernel::take_push(ByteView body) {
  const auto tuple = must(read_push(body));
  const auto number = number_of(*tuple.data);
  if (tuple.key == "bench.done") return void(is_over_ = number > 0);
  if (number == 0) return;  // the value before the first set
  ++values_;
  auto& known = numbers_[number % numbers_.size()];
  known = std::max(known, number);
}

void SlowKernel::acknowledge() {
  send_direct(Port::kAcks, write(Acks{std::exchange(acks_, {})}), false);
}

void SlowKernel::leave() {
  PackageHeader header;
  header.routing = Routing::kBroadcast;
  header.port = Port::kDeadHost;
  send(header, write(DeadHost{kKernel, DeathReason::kLost}));
}

}  // namespace rubicon::bench::peis
