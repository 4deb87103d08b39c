#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

#include "knx/measurements.h"

namespace rubicon::bench::knx {

namespace {

using Frame = std::array<std::uint8_t, 64>;

/// Just enough of a tunnel to send as fast as one telegram after the other goes; nothing is checked, nothing survives.
class BareTunnel {
 public:
  explicit BareTunnel(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) throw std::runtime_error("connect");
    const std::uint8_t connect[] = {6, 0x10, 2, 5, 0, 0x1a, 8, 1, 0, 0, 0, 0, 0, 0, 8, 1, 0, 0, 0, 0, 0, 0, 4, 4, 2, 0};
    put(connect, sizeof connect);
    do {
      take();
    } while (frame_[2] != 2 || frame_[3] != 6);
    channel_ = frame_[6];
  }
  ~BareTunnel() {
    const std::uint8_t end[] = {6, 0x10, 2, 9, 0, 0x10, channel_, 0, 8, 1, 0, 0, 0, 0, 0, 0};
    put(end, sizeof end);
    ::close(socket_);
  }
  BareTunnel(const BareTunnel&) = delete;
  BareTunnel& operator=(const BareTunnel&) = delete;

  /// TUNNELLING_REQUEST, its ack, L_Data.con, our ack (knx.md, 18).
  void write(std::uint8_t value) {
    const std::uint8_t request[] = {6,    0x10, 4, 0x20, 0,    0x17, 4, channel_, sequence_++, 0,    0x11, 0,
                                    0xbc, 0xe0, 0, 0,    0x0a, 7,    3, 0,        0x80,        0x0c, value};
    put(request, sizeof request);
    do {
      take();
      if (frame_[3] != 0x20) continue;
      const std::uint8_t ack[] = {6, 0x10, 4, 0x21, 0, 0x0a, 4, channel_, frame_[8], 0};
      put(ack, sizeof ack);
    } while (frame_[3] != 0x20 || frame_[10] != 0x2e);
  }

 private:
  void put(const std::uint8_t* bytes, std::size_t size) {
    if (::send(socket_, bytes, size, 0) < 0) throw std::runtime_error("send");
  }
  void take() {
    if (::recv(socket_, frame_.data(), frame_.size(), 0) < 0) throw std::runtime_error("receive");
  }

  int socket_;
  std::uint8_t channel_ = 0, sequence_ = 0;
  Frame frame_{};
};

}  // namespace

double floor_telegrams(int telegrams, std::uint16_t port) {
  BareTunnel tunnel(port);
  const auto start = Clock::now();
  for (int i = 0; i < telegrams; ++i) tunnel.write(static_cast<std::uint8_t>(i));
  return telegrams / seconds_since(start);
}

}  // namespace rubicon::bench::knx
