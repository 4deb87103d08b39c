#include "install/notice_socket.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>

namespace rubicon::install {

using Clock = std::chrono::steady_clock;

NoticeSocket::NoticeSocket(std::string path)
    : path_(std::move(path)), socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path_.copy(address.sun_path, sizeof address.sun_path - 1);
  ::unlink(path_.c_str());
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) path_.clear();
}

NoticeSocket::~NoticeSocket() {
  ::close(socket_);
  ::unlink(path_.c_str());
}

std::optional<std::string> NoticeSocket::next(std::chrono::milliseconds patience) {
  pollfd wanted{socket_, POLLIN, 0};
  if (::poll(&wanted, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
  std::array<char, 4096> buffer;
  const auto count = ::recv(socket_, buffer.data(), buffer.size(), 0);
  if (count < 0) return std::nullopt;
  return std::string(buffer.data(), static_cast<std::size_t>(count));
}

std::string NoticeSocket::next_with(const std::string& part) {
  const auto end = Clock::now() + std::chrono::seconds(60);
  while (Clock::now() < end) {
    auto notice = next(std::chrono::seconds(1));
    if (notice && notice->find(part) != notice->npos) return std::move(*notice);
  }
  return {};
}

}  // namespace rubicon::install
