#include "peis/bare.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "components/windows.h"
#include "peis/measurements.h"

namespace rubicon::bench::peis {

namespace {

constexpr std::uint16_t kBarePort = 17391;

sockaddr_in bare_address() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(kBarePort);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

void set(int socket, int level, int option) {
  const int on = 1;
  ::setsockopt(socket, level, option, &on, sizeof on);
}

}  // namespace

BareConnection::BareConnection(int socket) : socket_(socket) {
  set(socket_, IPPROTO_TCP, TCP_NODELAY);
}

BareConnection::BareConnection(BareConnection&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

BareConnection::~BareConnection() {
  if (socket_ >= 0) ::close(socket_);
}

BareConnection BareConnection::connect() {
  const auto address = bare_address();
  for (int i = 0; i < 1000; ++i) {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
      return BareConnection(socket);
    ::close(socket);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error("the other end of a bare connection does not listen");
}

BareConnection BareConnection::accept() {
  const auto address = bare_address();
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  set(listener, SOL_SOCKET, SO_REUSEADDR);
  const bool listens =
      ::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 && ::listen(listener, 1) == 0;
  const int socket = listens ? ::accept(listener, nullptr, nullptr) : -1;
  ::close(listener);
  if (socket < 0) throw std::runtime_error("cannot accept a bare connection");
  return BareConnection(socket);
}

void BareConnection::send(const std::vector<std::uint8_t>& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const auto sent = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (sent <= 0) throw std::runtime_error("cannot send on a bare connection");
    done += static_cast<std::size_t>(sent);
  }
}

bool BareConnection::receive(std::vector<std::uint8_t>& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const auto got = ::recv(socket_, bytes.data() + done, bytes.size() - done, 0);
    if (got <= 0) return false;
    done += static_cast<std::size_t>(got);
  }
  return true;
}

std::size_t BareConnection::receive_some(std::vector<std::uint8_t>& bytes) {
  const auto got = ::recv(socket_, bytes.data(), bytes.size(), 0);
  return got > 0 ? static_cast<std::size_t>(got) : 0;
}

Json bare_ping(const Meeting&, const Json& options) {
  const auto pace = std::chrono::microseconds(options.at("pace_us").get<int>());
  const double seconds = options.at("seconds").get<double>() + 1;
  auto connection = BareConnection::connect();
  std::vector<std::uint8_t> bytes(bytes_of_push());
  Windows windows;
  auto now = std::chrono::steady_clock::now();
  windows.begin(now);
  for (auto due = now; windows.seconds(now) <= seconds; due = std::max(due + pace, now)) {
    if (pace.count() > 0) std::this_thread::sleep_until(due);
    const auto sent = std::chrono::steady_clock::now();
    connection.send(bytes);
    if (!connection.receive(bytes)) throw std::runtime_error("the other end of a bare connection closed");
    now = std::chrono::steady_clock::now();
    windows.add(sent, now);
  }
  return windows.json();
}

Json bare_pong(const Meeting&, const Json&) {
  auto connection = BareConnection::accept();
  std::vector<std::uint8_t> bytes(bytes_of_push());
  while (connection.receive(bytes)) connection.send(bytes);
  return Json::object();
}

/// Blocks of 32 KiB, as the engine writes them to a component of ours.
Json bare_source(const Meeting&, const Json& options) {
  auto connection = BareConnection::connect();
  std::vector<std::uint8_t> bytes(32 * 1024);
  const auto start = Clock::now();
  while (seconds_since(start) < options.at("seconds").get<double>()) connection.send(bytes);
  return {{"processor_s", own_processor_seconds()}};
}

Json bare_sink(const Meeting&, const Json&) {
  auto connection = BareConnection::accept();
  std::vector<std::uint8_t> bytes(64 * 1024);
  std::size_t total = 0;
  const auto start = Clock::now();
  while (const auto got = connection.receive_some(bytes)) total += got;
  const auto count = static_cast<double>(total) / static_cast<double>(bytes_of_push());
  return {{"per_second", count / seconds_since(start)}, {"count", count}, {"processor_s", own_processor_seconds()}};
}

}  // namespace rubicon::bench::peis
