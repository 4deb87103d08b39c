#include "transport/memory_udp.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::transport {

namespace {

constexpr std::uint16_t kFirstFreePort = 49152;

bool is_numeric(const std::string& host) {
  return host.find(':') != std::string::npos || host.find_first_not_of("0123456789.") == std::string::npos;
}

class MemoryLookup final : public Lookup {
 public:
  Timer timer;
};

}  // namespace

class MemoryUdp final : public UdpSocket {
 public:
  MemoryUdp(MemoryNet& net, Endpoint local) : net_(net), local_(std::move(local)) {}
  ~MemoryUdp() override { net_.ports_.erase(local_); }
  MemoryUdp(const MemoryUdp&) = delete;
  MemoryUdp& operator=(const MemoryUdp&) = delete;

  Result<void> send(const Endpoint& to, ByteView bytes) override {
    if (!is_numeric(to.address) || to.port == 0)
      return fail(ErrorCode::kInvalid, fmt::format("UDP: no endpoint: {}", to_string(to)));
    if (bytes.size() > 65507)
      return fail(ErrorCode::kOutOfRange, fmt::format("UDP {}: {} bytes do not fit", to_string(to), bytes.size()));
    if (net_.refuses > 0) {
      --net_.refuses;
      ++dropped_;
      return fail(ErrorCode::kBusy, fmt::format("UDP {}: {} datagrams wait already", to_string(to), kMaxQueued));
    }
    net_.send({local_, to, Bytes(bytes.begin(), bytes.end())});
    return {};
  }
  Endpoint local() const override { return local_; }
  std::uint64_t dropped() const override { return dropped_; }

 private:
  MemoryNet& net_;
  Endpoint local_;
  std::uint64_t dropped_ = 0;
};

MemoryNet::MemoryNet(Scheduler& scheduler) : scheduler_(scheduler) {
  name("localhost", {"127.0.0.1"});
}

MemoryNet::~MemoryNet() = default;

void MemoryNet::name(const std::string& host, std::vector<std::string> addresses) {
  names_[host] = std::move(addresses);
}

std::size_t MemoryNet::open_sockets() const {
  return ports_.size();
}

Result<std::unique_ptr<UdpSocket>> MemoryNet::open_udp(const std::string& host, const UdpOptions& options,
                                                       UdpCalls calls) {
  Endpoint local{host, options.local.port};
  if (local.port == 0) {
    for (local.port = kFirstFreePort; ports_.contains(local);) ++local.port;
  }
  if (ports_.contains(local))
    return fail(ErrorCode::kBusy, fmt::format("UDP {}: cannot open: Address already in use", to_string(options.local)));
  ports_.emplace(local, std::make_shared<Port>(Port{options.largest, std::move(calls)}));
  return std::make_unique<MemoryUdp>(*this, local);
}

std::unique_ptr<Lookup> MemoryNet::look_up(const std::string& host, LookupDone done) {
  auto lookup = std::make_unique<MemoryLookup>();
  if (!names_answer) return lookup;
  const auto found = names_.find(host);
  Result<std::vector<std::string>> answer =
      fail(ErrorCode::kUnreachable, fmt::format("host {} cannot be found: Name or service not known", host));
  if (is_numeric(host)) {
    answer = std::vector<std::string>{host};
  } else if (found != names_.end() && !found->second.empty()) {
    answer = found->second;
  }
  lookup->timer = scheduler_.after(lookup_time, [done = std::move(done), answer = std::move(answer)] { done(answer); });
  return lookup;
}

void MemoryNet::send(MemoryDatagram datagram) {
  sent_.push_back(datagram);
  if (loses && loses(datagram)) return;
  const auto flight = ++last_flight_;
  flights_[flight] = scheduler_.after(transit, [this, flight, datagram = std::move(datagram)] {
    const auto landed = std::move(flights_.extract(flight).mapped());
    arrive(datagram);
  });
}

void MemoryNet::arrive(const MemoryDatagram& datagram) {
  const auto to = ports_.find(datagram.to);
  if (to != ports_.end()) {
    const auto port = to->second;  // may close itself in the call
    const auto size = std::min(datagram.bytes.size(), port->largest);
    return port->calls.received(datagram.from, ByteView(datagram.bytes).first(size));
  }
  const auto from = ports_.find(datagram.from);
  if (!reports_unreachable || from == ports_.end()) return;
  const auto port = from->second;
  port->calls.undelivered(
      {ErrorCode::kUnreachable, fmt::format("UDP {}: the datagram was not delivered", to_string(datagram.to))});
}

}  // namespace rubicon::transport
