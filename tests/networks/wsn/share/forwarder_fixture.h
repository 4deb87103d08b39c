#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "networks/wsn/share/forwarder.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::wsn::share {

using namespace std::chrono_literals;

/// A packet with its number, in the form of wsn.md 3: dispatch, AM header, payload of `size` bytes.
inline Bytes packet(std::uint8_t number, std::size_t size = 4, std::uint8_t type = 0x1c) {
  Bytes bytes{0x00, 0x00, 0x01, 0x00, 0x00, static_cast<std::uint8_t>(size), 0x00, type};
  bytes.resize(8 + size, number);
  return bytes;
}

/// As in the stream.
inline Bytes sent(const Bytes& packet) {
  Bytes bytes{static_cast<std::uint8_t>(packet.size())};
  bytes.insert(bytes.end(), packet.begin(), packet.end());
  return bytes;
}

inline const Bytes kHello{0x55, 0x20};

/// Another program, which follows wsn.md 4.1.
struct Program {
  std::unique_ptr<transport::TcpStream> stream;
  Bytes heard;
  bool disconnected = false;

  void connect(transport::Transports& transports) {
    transport::TcpCallbacks calls;
    calls.received = [this](ByteView bytes) { heard.insert(heard.end(), bytes.begin(), bytes.end()); };
    calls.failed = [this](const Error&) { disconnected = true; };
    stream = std::move(transports.open_tcp({{"127.0.0.1", 9002}}, std::move(calls))).value();
  }
  void greet(transport::Transports& transports) {
    connect(transports);
    send(kHello);
  }
  void send(const Bytes& bytes) { EXPECT_TRUE(stream->send(bytes)); }
  void say(const Bytes& packet) { send(sent(packet)); }
  /// What followed the greeting, split into packets.
  std::vector<Bytes> packets() const {
    std::vector<Bytes> all;
    for (std::size_t at = 2; at < heard.size(); at += std::size_t{1} + heard[at]) {
      const auto first = heard.begin() + static_cast<std::ptrdiff_t>(at + 1);
      all.emplace_back(first, first + heard[at]);
    }
    return all;
  }
};

class ForwarderTest : public ::testing::Test {
 protected:
  ForwarderTest() { host.join(net); }

  void open(ForwarderOptions options = {}) {
    ForwarderCallbacks calls;
    calls.packet = [this](ByteView bytes) {
      if (taken.size() >= space) return ++refused, false;
      taken.emplace_back(bytes.begin(), bytes.end());
      return true;
    };
    calls.failed = [this](const Error& error) { failures.push_back(error); };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.push_back(subject + ": " + std::string(text));
    };
    forwarder = std::make_unique<Forwarder>(std::move(options), time, host, std::move(calls));
    ASSERT_TRUE(forwarder->open());
  }
  void run(Duration span = 1s) { time.run_for(span); }
  /// So many packets more are taken.
  void make_room(std::size_t more) {
    space = taken.size() + more;
    forwarder->resume();
    run();
  }
  std::uint64_t counted(const std::string& name) const { return forwarder->counters().at(name); }
  std::vector<int> numbers() const {
    std::vector<int> all;
    for (const auto& one : taken) all.push_back(one.back());
    return all;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports host;
  std::vector<Bytes> taken;
  std::size_t space = 1000000, refused = 0;
  std::vector<Error> failures;
  std::vector<std::string> notes;
  std::unique_ptr<Forwarder> forwarder;
};

}  // namespace rubicon::networks::wsn::share
