#include "support/memory/memory_udp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace rubicon::transport {

namespace {

constexpr std::uint16_t kFirstFreePort = 49152;

bool is_group(const std::string& address) {
  const auto first = std::strtoul(address.c_str(), nullptr, 10);
  return address.find(':') == std::string::npos && first >= 224 && first < 240;
}

class MemoryLookup final : public Lookup {
 public:
  Timer timer;
};

}  // namespace

bool is_numeric_address(const std::string& host) {
  return host.find(':') != std::string::npos || host.find_first_not_of("0123456789.") == std::string::npos;
}

class MemoryUdp final : public UdpSocket {
 public:
  MemoryUdp(MemoryNet& net, MemoryNet::PortPtr port) : net_(net), port_(std::move(port)) {}
  ~MemoryUdp() override {
    port_->open = false;
    std::erase(net_.ports_, port_);
  }
  MemoryUdp(const MemoryUdp&) = delete;
  MemoryUdp& operator=(const MemoryUdp&) = delete;

  Result<void> send(const Endpoint& to, ByteView bytes) override {
    if (!is_numeric_address(to.address) || to.port == 0)
      return fail(ErrorCode::kInvalid, fmt::format("UDP: no endpoint: {}", to_string(to)));
    if (port_->options.remote && *port_->options.remote != to)
      return fail(ErrorCode::kInvalid,
                  fmt::format("UDP {}: the socket sends to {} only", to_string(to), to_string(*port_->options.remote)));
    if (bytes.size() > 65507)
      return fail(ErrorCode::kOutOfRange, fmt::format("UDP {}: {} bytes do not fit", to_string(to), bytes.size()));
    if (!net_.no_way.empty()) {
      ++dropped_;
      return fail(ErrorCode::kIo, fmt::format("UDP {}: cannot send: {}", to_string(to), net_.no_way));
    }
    if (net_.gone_interfaces.contains(port_->options.local.address))
      return fail(ErrorCode::kIo, fmt::format("UDP {}: cannot send: Network is unreachable", to_string(to)));
    if (net_.refuses > 0) {
      --net_.refuses;
      ++dropped_;
      return fail(ErrorCode::kBusy, fmt::format("UDP {}: {} datagrams wait already", to_string(to), kMaxQueued));
    }
    net_.send({port_->local, to, Bytes(bytes.begin(), bytes.end())}, *port_);
    return {};
  }
  Result<void> rejoin() override {
    const auto& multicast = port_->options.multicast;
    if (!multicast || multicast->groups.empty() || !net_.gone_interfaces.contains(port_->local.address)) return {};
    return fail(ErrorCode::kIo, fmt::format("cannot join group {} on {}: No such device", multicast->groups.front(),
                                            port_->local.address));
  }
  Endpoint local() const override { return port_->local; }
  std::uint64_t dropped() const override { return dropped_; }

 private:
  MemoryNet& net_;
  MemoryNet::PortPtr port_;
  std::uint64_t dropped_ = 0;
};

MemoryNet::MemoryNet(Scheduler& scheduler) : tcp(scheduler), scheduler_(scheduler) {
  name("localhost", {"127.0.0.1"});
}

MemoryNet::~MemoryNet() = default;

void MemoryNet::name(const std::string& host, std::vector<std::string> addresses) {
  names_[host] = std::move(addresses);
}

std::size_t MemoryNet::open_sockets() const {
  return ports_.size();
}

bool MemoryNet::taken(const Endpoint& local, bool reuse) const {
  return std::any_of(ports_.begin(), ports_.end(),
                     [&](const auto& port) { return port->local == local && !(reuse && port->options.reuse_address); });
}

Result<std::unique_ptr<UdpSocket>> MemoryNet::open_udp(const std::string& host, const UdpOptions& options,
                                                       UdpCallbacks calls) {
  Endpoint local{host, options.local.port};
  if (local.port == 0) {
    for (local.port = kFirstFreePort; taken(local, false);) ++local.port;
  }
  const auto cannot = [&](ErrorCode code, const std::string& what) {
    return fail(code, fmt::format("UDP {}: cannot {}", to_string(options.local), what));
  };
  if (taken(local, options.reuse_address)) return cannot(ErrorCode::kBusy, "open: Address already in use");
  if (options.multicast) {
    const auto& on = options.multicast->interface_address;
    if (!on.empty() && on != host)
      return cannot(ErrorCode::kIo,
                    fmt::format("send to groups from the interface of {}: Cannot assign requested address", on));
    for (const auto& group : options.multicast->groups)
      if (!is_group(group))
        return cannot(ErrorCode::kIo, fmt::format("join group {} on {}: Invalid argument", group, host));
  }
  ports_.push_back(std::make_shared<Port>(Port{local, options, std::move(calls), true}));
  return std::make_unique<MemoryUdp>(*this, ports_.back());
}

std::unique_ptr<Lookup> MemoryNet::look_up(const std::string& host, LookupDone done) {
  auto lookup = std::make_unique<MemoryLookup>();
  if (!names_answer) return lookup;
  const auto found = names_.find(host);
  Result<std::vector<std::string>> answer =
      fail(ErrorCode::kUnreachable, fmt::format("host {} cannot be found: Name or service not known", host));
  if (is_numeric_address(host)) {
    answer = std::vector<std::string>{host};
  } else if (found != names_.end() && !found->second.empty()) {
    answer = found->second;
  }
  lookup->timer = scheduler_.after(lookup_time, [done = std::move(done), answer = std::move(answer)] { done(answer); });
  return lookup;
}

void MemoryNet::send(MemoryDatagram datagram, const Port& from) {
  sent_.push_back(datagram);
  if (loses && loses(datagram)) return;
  if (!is_group(datagram.to.address)) return fly(std::move(datagram), [this](const auto& landed) { arrive(landed); });
  const bool loopback = !from.options.multicast || from.options.multicast->loopback;
  fly(std::move(datagram), [this, loopback](const auto& landed) { arrive_in_group(landed, loopback); });
}

void MemoryNet::fly(MemoryDatagram datagram, std::function<void(const MemoryDatagram&)> land) {
  const auto flight = ++last_flight_;
  flights_[flight] = scheduler_.after(transit, [this, flight, datagram = std::move(datagram), land = std::move(land)] {
    const auto landed = std::move(flights_.extract(flight).mapped());
    land(datagram);
  });
}

void MemoryNet::hear(const PortPtr& port, const MemoryDatagram& datagram) {
  const auto& options = port->options;
  if (!port->open || (options.remote && *options.remote != datagram.from)) return;
  port->calls.received(datagram.from, ByteView(datagram.bytes).first(std::min(datagram.bytes.size(), options.largest)));
}

void MemoryNet::arrive_in_group(const MemoryDatagram& datagram, bool loopback) {
  for (const auto& port : std::vector<PortPtr>(ports_)) {
    const auto& bound = port->options.local.address;
    const auto& multicast = port->options.multicast;
    if (!multicast || port->local.port != datagram.to.port) continue;
    if (is_group(bound) && bound != datagram.to.address) continue;
    if (!loopback && port->local.address == datagram.from.address) continue;
    const auto& groups = multicast->groups;
    if (std::find(groups.begin(), groups.end(), datagram.to.address) != groups.end()) hear(port, datagram);
  }
}

/// Delivers to the socket that was bound last, as Linux does for shared ports.
void MemoryNet::arrive(const MemoryDatagram& datagram) {
  const auto to = std::find_if(ports_.rbegin(), ports_.rend(), [&](const auto& port) {
    return port->local == datagram.to && !is_group(port->options.local.address);
  });
  if (to != ports_.rend()) return hear(PortPtr(*to), datagram);  // may close itself in the call
  const auto from =
      std::find_if(ports_.begin(), ports_.end(), [&](const auto& port) { return port->local == datagram.from; });
  if (!reports_unreachable || from == ports_.end()) return;
  const auto port = *from;
  port->calls.undelivered(
      {ErrorCode::kUnreachable, fmt::format("UDP {}: the datagram was not delivered", to_string(datagram.to))});
}

}  // namespace rubicon::transport
