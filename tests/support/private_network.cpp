#include "support/private_network.h"

#include <fcntl.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace rubicon::support {

namespace {

/// A new network begins with its loopback down.
bool raise_loopback() {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  const bool done = socket >= 0 && ::ioctl(socket, SIOCSIFFLAGS, &request) == 0;
  if (socket >= 0) ::close(socket);
  return done;
}

}  // namespace

PrivateNetwork::PrivateNetwork() : former_(::open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC)) {
  entered_ = former_ >= 0 && ::unshare(CLONE_NEWNET) == 0;
  if (entered_ && raise_loopback()) return;
  reason_ = std::string("no private network: ") + std::strerror(errno);
  leave();
}

PrivateNetwork::~PrivateNetwork() {
  leave();
  if (former_ >= 0) ::close(former_);
}

void PrivateNetwork::leave() {
  if (entered_ && ::setns(former_, CLONE_NEWNET) != 0) std::abort();
  entered_ = false;
}

}  // namespace rubicon::support
