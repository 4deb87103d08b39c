#include "ecology/lan.h"

#include <fcntl.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "support/process.h"

namespace rubicon::ecology {

namespace {

int this_network() {
  return ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
}

void write_file(const char* path, const std::string& text) {
  std::ofstream(path) << text;
}

void raise_loopback() {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  ::ioctl(socket, SIOCSIFFLAGS, &request);
  ::close(socket);
}

/// Into a network of this program's own, once and for good: a user who is not root cannot go back. Empty, or why not.
std::string leave_the_real_network() {
  static const std::string reason = [] {
    const auto user = ::getuid(), group = ::getgid();
    if (::unshare(CLONE_NEWNET) == 0) return std::string();
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
      return std::string("no network namespaces: ") + std::strerror(errno);
    write_file("/proc/self/setgroups", "deny");
    write_file("/proc/self/uid_map", "0 " + std::to_string(user) + " 1");
    write_file("/proc/self/gid_map", "0 " + std::to_string(group) + " 1");
    return std::string();
  }();
  return reason;
}

bool ip(const std::string& arguments) {
  std::vector<std::string> words{"ip"};
  std::istringstream in(arguments);
  for (std::string word; in >> word;) words.push_back(word);
  return support::run_to_end(words).code == 0;
}

}  // namespace

Host::Host() {
  if (!leave_the_real_network().empty()) return;
  const int former = this_network();
  if (::unshare(CLONE_NEWNET) != 0) return;
  raise_loopback();
  write_file("/proc/sys/net/ipv6/conf/all/disable_ipv6", "1");  // it speaks up by itself
  descriptor_ = this_network();
  folder_ = support::MeetingFolder::make();
  if (::setns(former, CLONE_NEWNET) != 0) std::abort();
  ::close(former);
}

Host::~Host() {
  if (descriptor_ >= 0) ::close(descriptor_);
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

Host::Host(Host&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), folder_(std::exchange(other.folder_, {})) {}

std::string Host::name() const {
  return "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(descriptor_);
}

Host::Visit::Visit(const Host& host) : former_(this_network()), folder_(host.folder_) {
  if (::setns(host.descriptor(), CLONE_NEWNET) != 0) std::abort();
}

Host::Visit::~Visit() {
  if (::setns(former_, CLONE_NEWNET) != 0) std::abort();
  ::close(former_);
}

long Host::packets_sent(const std::string& interface) const {
  const Visit visit(*this);
  std::ifstream file("/proc/thread-self/net/dev");
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string name;
    in >> name;
    if (name != interface + ":") continue;
    long number = -1;
    for (int column = 0; column < 10; ++column) in >> number;  // received: 8 columns; sent: bytes, packets
    return number;
  }
  return -1;
}

Lan::Lan(int hosts) {
  reason_ = leave_the_real_network();
  if (!reason_.empty()) return;
  for (int i = 0; i < hosts; ++i) hosts_.emplace_back();
  if (!connect()) reason_ = "no virtual cables: the program `ip` (iproute2) is absent, or may not make them";
}

bool Lan::connect() {
  const Host::Visit visit(switch_);
  if (!ip("link add switch type bridge forward_delay 0 mcast_snooping 0") || !ip("link set switch up")) return false;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    const auto end = "port" + std::to_string(i);
    if (!ip("link add " + end + " type veth peer name " + kCable + " netns " + hosts_[i].name())) return false;
    if (!ip("link set " + end + " master switch up")) return false;
    const Host::Visit inside(hosts_[i]);
    if (!ip("address add " + address(static_cast<int>(i)) + "/24 dev " + kCable)) return false;
    interface_up(static_cast<int>(i));
  }
  return true;
}

void Lan::port(int host, const std::string& state) const {
  const Host::Visit visit(switch_);
  ip("link set port" + std::to_string(host) + " " + state);
}

void Lan::loopback_down(int number) const {
  const Host::Visit visit(host(number));
  ip("link set lo down");
}

void Lan::interface_down(int number) const {
  const Host::Visit visit(host(number));
  ip(std::string("link set ") + kCable + " down");
}

void Lan::interface_up(int number) const {
  const Host::Visit visit(host(number));
  ip(std::string("link set ") + kCable + " up");
}

void Lan::change_address(int number, const std::string& from, const std::string& to) const {
  const Host::Visit visit(host(number));
  if (!from.empty()) ip("addr del " + from + "/24 dev " + kCable);
  if (!to.empty()) ip("addr add " + to + "/24 dev " + kCable);
}

void Lan::interface_without_multicast(int number) const {
  const Host::Visit visit(host(number));
  ip(std::string("link set ") + kCable + " multicast off");
}

}  // namespace rubicon::ecology
