#include "transport/mosquitto_socket.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace rubicon::transport {

KeptSocket::KeptSocket(int socket) : descriptor_(::fcntl(socket, F_DUPFD_CLOEXEC, 0)) {}

KeptSocket::~KeptSocket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void KeptSocket::await_end(std::chrono::steady_clock::time_point latest) const {
  if (descriptor_ < 0) return;
  ::shutdown(descriptor_, SHUT_WR);
  std::array<char, 65536> bytes;
  for (auto left = latest - std::chrono::steady_clock::now(); left > std::chrono::steady_clock::duration::zero();
       left = latest - std::chrono::steady_clock::now()) {
    pollfd ready{descriptor_, POLLIN, 0};
    const auto patience = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    if (::poll(&ready, 1, static_cast<int>(patience)) <= 0) continue;
    const auto count = ::recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) return;
  }
}

void acknowledge_now(int socket) {
  const int yes = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_QUICKACK, &yes, sizeof yes);
}

bool is_ended(int socket) {
  char byte = 0;
  return ::recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

}  // namespace rubicon::transport
