#include "apps/rubicon/doctor/findings.h"

#include <arpa/inet.h>
#include <fmt/format.h>
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
#include <map>
#include <sstream>
#include <utility>

#include "apps/rubicon/doctor/island_findings.h"
#include "apps/rubicon/output/table.h"
#include "base/text.h"
#include "transport/host_names.h"
#include "tuples/dds/dds_options.h"
#include "tuples/peer_policy.h"

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

namespace {

using Grade = Finding::Grade;

constexpr const char* kMulticast = "no-multicast";
constexpr const char* kTwins = "island-twice";
constexpr const char* kVersion = "version";

bool only_loopback(const client::Options& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(), [](const auto& one) { return one == "lo"; });
}

std::string names_of(const std::vector<transport::Interface>& there) {
  std::string names;
  for (const auto& one : there) names += (names.empty() ? "" : ", ") + one.name;
  return names;
}

Finding check_interface(const std::string& name, bool needs_multicast, const std::vector<transport::Interface>& there) {
  const auto found = std::find_if(there.begin(), there.end(), [&](const auto& one) { return one.name == name; });
  if (found == there.end())
    return {"interface", Grade::kProblem, fmt::format("{} is not an interface of this host", name),
            fmt::format("--interfaces takes: {}", names_of(there))};
  if (!found->is_up)
    return {"interface", Grade::kProblem, fmt::format("{} is down", name), fmt::format("ip link set {} up", name)};
  if (found->address.empty())
    return {"interface", Grade::kProblem, fmt::format("{} has no IPv4 address", name),
            fmt::format("ip address add ADDRESS/24 dev {}, or wait for DHCP", name)};
  if (needs_multicast && !found->has_multicast)
    return {kMulticast, Grade::kProblem,
            fmt::format("{} ({}) has no multicast: components there cannot discover each other", name, found->address),
            fmt::format("name the other hosts (--peers, tuples.peers), or: ip link set {} multicast on", name)};
  return {"interface", Grade::kGood, fmt::format("{} ({}) is up", name, found->address)};
}

std::string who(const client::ComponentStart& one) {
  auto text = one.summary.host.empty() ? std::string("an unknown host") : one.summary.host;
  if (!one.summary.program.empty()) text += " (" + one.summary.program + ")";
  return text;
}

}  // namespace

std::string_view to_string(Finding::Grade grade) {
  switch (grade) {
    case Grade::kGood: return "good";
    case Grade::kNote: return "note";
    case Grade::kProblem: return "problem";
  }
  return "good";
}

Findings check_folder(const client::HostView& view) {
  Findings all{
      {"folder", Grade::kGood, fmt::format("programs of this host meet in {}, space {}", view.folder, view.space)}};
  for (const auto& who : view.awaited)
    all.push_back({"folder", Grade::kProblem, fmt::format("{} does not say who it is", who),
                   "it hangs or is stopped: look at it, for example with `ps`"});
  return all;
}

Findings check_interfaces(const client::Options& options, const std::vector<transport::Interface>& there) {
  Findings all;
  const bool needs_multicast = !only_loopback(options) && options.peers.empty();
  for (const auto& name : options.interfaces) all.push_back(check_interface(name, needs_multicast, there));
  return all;
}

Finding check_places(std::uint32_t domain, unsigned processes) {
  if (processes >= tuples::dds::kMaxProcessesPerHost)
    return {"participant-index", Grade::kProblem,
            fmt::format("all {} participant indexes of this host in domain {} are in use",
                        tuples::dds::kMaxProcessesPerHost, domain),
            "end programs that are not needed (`ss -lunp` lists them), or give some islands another tuples.domain"};
  return {"participant-index", Grade::kGood,
          fmt::format("{} of {} participant indexes of this host in domain {} are in use", processes,
                      tuples::dds::kMaxProcessesPerHost, domain)};
}

Finding check_peer(const std::string& peer, std::uint32_t domain, const Probe& probe) {
  const auto ports =
      fmt::format("{} to {}", tuples::dds::multicast_port_of(domain), tuples::dds::multicast_port_of(domain + 1) - 1);
  if (!probe.error.empty())
    return {"firewall", Grade::kProblem, fmt::format("cannot send to peer {}: {}", peer, probe.error),
            fmt::format("check the routes (`ip route get {}`) and the rules for outgoing UDP on this host", peer)};
  if (probe.silent > 0 && !probe.closed_port_refused)
    return {"firewall", Grade::kProblem,
            fmt::format("peer {} does not answer to UDP: it is off, or a firewall drops the datagrams", peer),
            fmt::format("allow UDP ports {} in both directions on both hosts", ports)};
  if (probe.silent == 0)
    return {"peer", Grade::kNote,
            fmt::format("peer {} answers, but no component runs there in domain {}", peer, domain),
            "start an island there, or look at its tuples.domain and tuples.interfaces"};
  return {"peer", Grade::kGood, fmt::format("peer {} answers, and something listens there in domain {}", peer, domain)};
}

Findings check_versions(const std::vector<client::ComponentStart>& seen, unsigned ours) {
  Findings all;
  for (const auto& one : seen) {
    if (!one.present || one.version == ours) continue;
    all.push_back({kVersion, Grade::kProblem,
                   fmt::format("component {} on {} uses protocol version {}, this program version {}: they "
                               "cannot communicate",
                               number(one.id), who(one), one.version, ours),
                   one.version > ours ? "install the same version of Rubicon here" : "install this version there"});
  }
  if (all.empty()) all.push_back({kVersion, Grade::kGood, fmt::format("all components use protocol version {}", ours)});
  return all;
}

Findings check_clocks(const std::vector<client::ComponentStart>& seen, WallTime now) {
  using tuples::DeclaredHostPolicy;
  Findings all;
  if (const auto good = DeclaredHostPolicy::check_clock(now); !good)
    all.push_back({"clock", Grade::kProblem, good.error().text, "set it: timedatectl set-ntp true"});
  for (const auto& one : seen) {
    const auto good = one.present ? DeclaredHostPolicy::check_start(one.id, one.incarnation) : Result<void>();
    if (good) continue;
    all.push_back(
        {"clock", Grade::kProblem, good.error().text + ": ignored",
         "on that host: `timedatectl` says whether its clock is set; its islands take part within seconds of that. A "
         "unit waits for it with `systemctl enable systemd-time-wait-sync`"});
  }
  return all;
}

Finding check_complaint(const std::string& text) {
  return {"complaint", Grade::kNote, text, "reported during the check; " + page("errors.md")};
}

Findings check_silent_participants(std::size_t silent, unsigned domain) {
  if (silent == 0) return {};
  return {{"silent", Grade::kNote,
           fmt::format("{} of domain {} {} no component: no program of Rubicon, or of a release that had certificates "
                       "for DDS",
                       counted(silent, "participant"), domain, silent == 1 ? "shows" : "show"),
           "islands of one network need the same release; " + page("trust.md")}};
}

Findings check_twins(const std::vector<client::ComponentStart>& seen) {
  std::map<OwnerId, std::vector<const client::ComponentStart*>> starts;
  for (const auto& one : seen) starts[one.id].push_back(&one);
  Findings all;
  for (const auto& entry : starts) {
    const auto& twins = entry.second;
    if (twins.size() < 2) continue;
    const auto there = std::count_if(twins.begin(), twins.end(), [](const auto* one) { return one->present; });
    std::string places;
    for (const auto* one : twins) places += (places.empty() ? "" : " and ") + who(*one);
    const auto id = number(entry.first);
    all.push_back({kTwins, Grade::kProblem,
                   there > 1 ? fmt::format("id {} is used by {} programs: {}", id, there, places)
                             : fmt::format("id {} started {} times during the check: {}", id, twins.size(), places),
                   fmt::format("give one of them another island.id; the one that started later exits by itself. Right "
                               "after a kill or a restart of {}, run doctor again in some seconds",
                               id)});
  }
  if (all.empty()) all.push_back({kTwins, Grade::kGood, "no duplicate ids"});
  return all;
}

}  // namespace rubicon::cli
