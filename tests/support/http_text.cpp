#include "support/http_text.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <tuple>

namespace rubicon::support {

std::string http_text(int port, const std::string& request, const std::string& fields) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    const auto text = request + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + fields + "\r\n";
    std::ignore = ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
    char piece[4096];
    for (ssize_t size = 0; (size = ::recv(socket, piece, sizeof piece, 0)) > 0;)
      answer.append(piece, static_cast<std::size_t>(size));
  }
  ::close(socket);
  return answer;
}

}  // namespace rubicon::support
