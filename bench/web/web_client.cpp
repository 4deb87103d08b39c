#include "web/web_client.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace rubicon::bench::web {

namespace {

using namespace std::chrono_literals;

constexpr auto kHandshakeTime = 60s;
constexpr useconds_t kBusyPause = 100'000;

int connect_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error(fmt::format("no connection to port {}", port));
  return socket;
}

std::size_t big_endian(std::string_view bytes) {
  std::size_t number = 0;
  for (const char byte : bytes) number = number << 8U | static_cast<unsigned char>(byte);
  return number;
}

/// The answer, with its head.
std::string answer_to(int port, const std::string& target) {
  const int socket = connect_to(port);
  const auto request = fmt::format("GET {} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n\r\n", target, port);
  std::string answer;
  std::array<char, 65536> piece;
  if (::send(socket, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
    for (ssize_t count = 0; (count = ::recv(socket, piece.data(), piece.size(), 0)) > 0;)
      answer.append(piece.data(), static_cast<std::size_t>(count));
  }
  ::close(socket);
  return answer;
}

}  // namespace

WebClient::WebClient(int port, std::string_view path, std::string_view protocol) : socket_(connect_to(port)) {
  write(fmt::format(
      "GET {} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n{}{}{}\r\n",
      path, port, protocol.empty() ? "" : "Sec-WebSocket-Protocol: ", protocol, protocol.empty() ? "" : "\r\n"));
  constexpr std::string_view kHeadEnd = "\r\n\r\n";
  const auto until = Clock::now() + kHandshakeTime;
  auto end = input_.npos;
  while ((end = input_.find(kHeadEnd)) == input_.npos) {
    if (!read(until)) throw std::runtime_error("no answer to a WebSocket's request");
  }
  if (!input_.starts_with("HTTP/1.1 101")) throw std::runtime_error(input_.substr(0, end));
  at_ = end + kHeadEnd.size();
}

WebClient::~WebClient() {
  ::close(socket_);
}

void WebClient::send(unsigned char opcode, std::string_view content) {
  constexpr std::size_t kShort = 125, kMedium = 0xffff;
  if (content.size() > kMedium) throw std::runtime_error("a message is too long");
  std::string frame{static_cast<char>(0x80U | opcode)};
  if (content.size() <= kShort) {
    frame += static_cast<char>(0x80U | content.size());
  } else {
    frame += static_cast<char>(0x80U | 126U);
    frame += static_cast<char>(content.size() >> 8U);
    frame += static_cast<char>(content.size() & 0xffU);
  }
  frame.append(4, '\0');  // a mask of zeros leaves the content as it is
  write(frame.append(content));
}

void WebClient::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const auto count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count <= 0) throw std::runtime_error("a connection was lost");
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

bool WebClient::read(Clock::time_point until) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
  pollfd ready{socket_, POLLIN, 0};
  if (::poll(&ready, 1, std::max(0, static_cast<int>(left.count()))) == 0) return false;
  input_.erase(0, std::exchange(at_, 0));
  std::array<char, 65536> piece;
  const auto count = ::recv(socket_, piece.data(), piece.size(), 0);
  if (count <= 0) throw std::runtime_error("a connection was lost");
  input_.append(piece.data(), static_cast<std::size_t>(count));
  return true;
}

std::optional<std::string_view> WebClient::next(Clock::time_point until) {
  if (std::exchange(complete_, false)) message_.clear();
  for (;;) {
    while (take_frame()) {
      if (complete_) return message_;
    }
    if (!read(until)) return std::nullopt;
  }
}

bool WebClient::take_frame() {
  const auto rest = std::string_view(input_).substr(at_);
  if (rest.size() < 2) return false;
  const auto first = static_cast<unsigned char>(rest[0]);
  std::size_t size = static_cast<unsigned char>(rest[1]) & 0x7fU, head = 2;
  if (size >= 126) head = size == 126 ? 4 : 10;
  if (rest.size() < head) return false;
  if (head > 2) size = big_endian(rest.substr(2, head - 2));
  if (rest.size() < head + size) return false;
  const auto content = rest.substr(head, size);
  at_ += head + size;
  const auto opcode = first & 0x0fU;
  if (opcode == kPing) send(kPong, std::string(content));
  if (opcode > kBinary) return true;
  message_ += content;
  complete_ = (first & 0x80U) != 0;
  return true;
}

std::size_t WebClient::discard() {
  std::array<char, 65536> piece;
  const auto count = ::recv(socket_, piece.data(), piece.size(), MSG_DONTWAIT);
  if (count == 0) throw std::runtime_error("a connection was lost");
  return count < 0 ? 0 : static_cast<std::size_t>(count);
}

std::string http_get(int port, const std::string& target) {
  auto answer = answer_to(port, target);
  for (; answer.starts_with("HTTP/1.1 429 "); answer = answer_to(port, target)) ::usleep(kBusyPause);
  const auto head = answer.find("\r\n\r\n");
  if (!answer.starts_with("HTTP/1.1 200 ") || head == answer.npos)
    throw std::runtime_error(fmt::format("{}: {}", target, answer.substr(0, answer.find("\r\n"))));
  return answer.substr(head + 4);
}

}  // namespace rubicon::bench::web
