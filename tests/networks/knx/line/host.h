#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::knx::line {

using transport::Endpoint;

inline Bytes bytes(std::string_view hex) {
  return base::from_hex(hex).value();
}

/// A socket of a host on the network of memory that keeps what it hears.
struct Host {
  Host(transport::MemoryNet& net, const std::string& address) : at(address) { lines.join(net, address); }
  void listen(std::vector<std::string> groups, std::uint16_t port) {
    transport::UdpOptions options{{groups.empty() ? "" : groups[0], port}};
    options.multicast = transport::UdpMulticast{std::move(groups), at};
    options.reuse_address = true;
    transport::UdpCallbacks calls;
    calls.received = [this](const Endpoint& from, ByteView frame) {
      received.emplace_back(from, base::to_hex(frame));
      if (answer) answer(from, frame);
    };
    calls.undelivered = [](const Error&) {};
    calls.failed = [](const Error&) { ADD_FAILURE(); };
    sockets.push_back(std::move(lines.open_udp(options, std::move(calls)).value()));
  }
  void send(const Endpoint& to, ByteView frame) { ASSERT_TRUE(sockets.back()->send(to, frame)); }

  std::string at;  ///< its address
  transport::MemoryTransports lines;
  std::function<void(const Endpoint& from, ByteView frame)> answer;
  std::vector<std::pair<Endpoint, std::string>> received;
  std::vector<std::unique_ptr<transport::UdpSocket>> sockets;
};

}  // namespace rubicon::networks::knx::line
