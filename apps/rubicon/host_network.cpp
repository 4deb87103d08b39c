#include "apps/rubicon/host_network.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

#include "base/host_port.h"
#include "base/text.h"
#include "transport/resolve.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::cli {

namespace {

using Clock = std::chrono::steady_clock;

/// Below all ports of DDS.
constexpr std::uint16_t kClosedPort = tuples::dds::multicast_port_of(0) - 1;
constexpr std::chrono::milliseconds kProbeTime{700};

class Socket {
 public:
  Socket() : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

sockaddr_in address_of(const std::string& address, std::uint16_t port) {
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(port);
  ::inet_pton(AF_INET, address.c_str(), &where.sin_addr);
  return where;
}

const sockaddr* as_any(const sockaddr_in& where) {
  return reinterpret_cast<const sockaddr*>(&where);  // the way of the sockets API
}

/// Sends one byte; the error, 0 = none.
int send_to(const Socket& socket, const sockaddr_in& where) {
  if (::connect(socket.get(), as_any(where), sizeof where) != 0) return errno;
  return ::send(socket.get(), "", 1, 0) == 1 ? 0 : errno;
}

/// Waits for refusals.
void wait_for_refusals(std::vector<pollfd>& waiting, Probe& probe) {
  const auto end = Clock::now() + kProbeTime;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0 || ::poll(waiting.data(), waiting.size(), static_cast<int>(left)) <= 0) return;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (waiting[i].revents == 0) continue;
      waiting[i].fd = -1;  // poll passes it over from now on
      if (i == 0) {
        probe.closed_port_refused = true;
      } else {
        ++probe.refused;
      }
    }
  }
}

}  // namespace

std::set<unsigned> ports_in(std::string_view table) {
  std::set<unsigned> ports;
  std::istringstream lines{std::string(table)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string number, local;
    words >> number >> local;
    const auto colon = local.rfind(':');
    if (colon == local.npos || number.empty() || number.back() != ':') continue;
    const auto port = base::parse_hex_number<unsigned>(std::string_view(local).substr(colon + 1));
    if (port) ports.insert(*port);
  }
  return ports;
}

std::set<unsigned> bound_ports() {
  std::ifstream file("/proc/net/udp");
  std::stringstream text;
  text << file.rdbuf();
  return ports_in(text.str());
}

std::map<unsigned, unsigned> processes_by_domain(const std::set<unsigned>& ports) {
  std::map<unsigned, unsigned> processes;
  for (const auto port : ports) {
    const auto domain = tuples::dds::domain_of_port(port);
    if (domain && ports.contains(port + 1)) ++processes[*domain];
  }
  return processes;
}

bool passes_udp(const std::string& address) {
  const Socket receiver, sender;
  auto where = address_of(address, 0);
  socklen_t size = sizeof where;
  if (::bind(receiver.get(), as_any(where), size) != 0) return false;
  if (::getsockname(receiver.get(), reinterpret_cast<sockaddr*>(&where), &size) != 0) return false;
  if (send_to(sender, where) != 0) return false;
  pollfd wanted{receiver.get(), POLLIN, 0};
  return ::poll(&wanted, 1, static_cast<int>(kProbeTime.count())) == 1;
}

Probe probe_peer(const std::string& peer, unsigned domain) {
  Probe probe;
  const auto with_port = base::parse_host_port(peer);
  const auto addresses = transport::resolve(with_port ? with_port->host : peer, transport::AddressFamily::kIpv4);
  if (!addresses) {
    probe.error = addresses.error().text;
    return probe;
  }
  const auto& address = addresses->front();
  std::vector<std::uint16_t> ports{kClosedPort};
  if (with_port) ports.push_back(with_port->port);
  for (unsigned i = 0; !with_port && i < tuples::dds::kProcessesSearchedOnPeer; ++i)
    ports.push_back(static_cast<std::uint16_t>(tuples::dds::port_of(domain, i)));
  std::vector<Socket> sockets(ports.size());
  std::vector<pollfd> waiting;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (const int error = send_to(sockets[i], address_of(address, ports[i])); error != 0 && error != ECONNREFUSED) {
      probe.error = std::strerror(error);
      return probe;
    }
    waiting.push_back({sockets[i].get(), POLLIN, 0});
  }
  wait_for_refusals(waiting, probe);
  probe.silent = static_cast<unsigned>(ports.size()) - 1 - probe.refused;
  return probe;
}

std::set<unsigned> domains_heard(const std::string& address, unsigned except, std::chrono::milliseconds patience) {
  std::vector<Socket> sockets(tuples::dds::kMaxDomain + 1);
  std::vector<pollfd> waiting;
  ip_mreq group{};
  ::inet_pton(AF_INET, "239.255.0.1", &group.imr_multiaddr);  // DDSI-RTPS 2.5, 9.6.2.4.1
  ::inet_pton(AF_INET, address.c_str(), &group.imr_interface);
  for (unsigned domain = 0; domain <= tuples::dds::kMaxDomain; ++domain) {
    const int descriptor = domain == except ? -1 : sockets[domain].get();
    const int yes = 1;
    const auto where = address_of("239.255.0.1", static_cast<std::uint16_t>(tuples::dds::multicast_port_of(domain)));
    const bool listens = descriptor >= 0 && ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
                         ::bind(descriptor, as_any(where), sizeof where) == 0 &&
                         ::setsockopt(descriptor, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) == 0;
    waiting.push_back({listens ? descriptor : -1, POLLIN, 0});
  }
  std::set<unsigned> heard;
  const auto end = Clock::now() + patience;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0 || ::poll(waiting.data(), waiting.size(), static_cast<int>(left)) <= 0) return heard;
    for (unsigned domain = 0; domain < waiting.size(); ++domain) {
      std::array<char, 4> magic{};
      if (waiting[domain].revents == 0) continue;
      const auto count = ::recv(waiting[domain].fd, magic.data(), magic.size(), 0);
      if (count == 4 && std::string_view(magic.data(), 4) == "RTPS") heard.insert(domain);
    }
  }
}

}  // namespace rubicon::cli
