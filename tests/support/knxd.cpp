#include "support/knxd.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace rubicon::support {

namespace {

/// In namespaces nothing is shared but the disk.
std::string own_path(const std::string& what) {
  static std::atomic<int> count = 0;
  return (std::filesystem::temp_directory_path() / fmt::format("rubicon-{}-{}-{}", what, ::getpid(), ++count)).string();
}

std::string configuration(const std::string& folder, bool routing, int users) {
  return fmt::format(R"([main]
name = test-knxd
addr = 1.1.250
client-addrs = 1.1.200:{}
connections = A.srv,B.unix,C.dummy
cache = gc
debug = dbg

[dbg]
error-level = 3

[gc]
max-size = 200

[A.srv]
server = ets_router
discover = {}
tunnel = tun
{}
interface = veth0
port = 3671
multicast-address = 224.0.23.12
heartbeat-timeout = 120

[tun]

[rt]

[B.unix]
server = knxd_unix
path = {}/knx.sock
systemd-ignore = false

[C.dummy]
driver = dummy
)",
                     users, routing, routing ? "router = rt" : "", folder);
}

std::string read_all(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

KnxNetwork::KnxNetwork() : reason_(network_.reason()) {
  if (!entered()) return;
  for (const auto* program : {"knxd", "knxtool", "ip"}) {
    if (support::run_to_end({"sh", "-c", std::string("command -v ") + program}).code == 0) continue;
    reason_ = std::string("the program ") + program + " is not installed";
    return;
  }
  const auto made = support::run_to_end({"sh", "-ec",
                                         fmt::format(R"(
    ip link add veth0 type veth peer name veth1
    ip address add {}/24 dev veth0
    ip link set veth0 up
    ip link set veth1 up
    ip route add 224.0.0.0/4 dev veth0
    ip route add default dev veth0)",
                                                     kAddress)});
  if (made.code != 0) reason_ = "no network for knxd: " + made.errors;
}

Knxd::Knxd(bool routing, int users) : folder_(own_path("knxd")), routing_(routing) {
  std::filesystem::create_directories(folder_);
  std::ofstream(folder_ + "/knxd.ini") << configuration(folder_, routing, users);
  restart();
}

void Knxd::kill() {
  process_.reset();
  std::error_code ignored;
  std::filesystem::remove(folder_ + "/knx.sock", ignored);
}

void Knxd::restart() {
  kill();
  process_ = std::make_unique<support::Process>(std::vector<std::string>{"knxd", folder_ + "/knxd.ini"});
}

Knxd::~Knxd() {
  process_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

/// The file is there a moment before somebody listens behind it, and its users may be served before the network.
bool Knxd::ready() const {
  const auto path = folder_ + "/knx.sock";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool there = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(probe);
  const bool bound = read_all("/proc/thread-self/net/udp").find(":0E57 ") != std::string::npos;
  const bool joined = read_all("/proc/thread-self/net/igmp").find("0C1700E0") != std::string::npos;
  return there && bound && (joined || !routing_);
}

support::Outcome Knxd::tool(const std::string& command, std::vector<std::string> arguments) const {
  std::vector<std::string> all{"knxtool", command, url()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return support::run_to_end(std::move(all));
}

KnxdListener::KnxdListener(const Knxd& knxd) : path_(own_path("heard")) {
  process_ = std::make_unique<support::Process>(std::vector<std::string>{
      "sh", "-c", fmt::format("exec knxtool groupsocketlisten {} >{} 2>&1", knxd.url(), path_)});
}

KnxdListener::~KnxdListener() {
  process_.reset();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

std::string KnxdListener::heard() const {
  return read_all(path_);
}

}  // namespace rubicon::support
