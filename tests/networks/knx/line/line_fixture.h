#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "networks/knx/line/tunnel_line.h"
#include "support/knx_server.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::knx::line {

using namespace std::chrono_literals;

/// A tunnel to a simulated server in memory, in virtual time. A lost line is reopened after a pause, as the
/// supervisor would, unless `reopens` is false.
class LineFixture : public testing::Test {
 protected:
  struct Outcome {
    SendOutcome sent;
    std::string why;
  };

  LineFixture() {
    transports.join(net, "10.0.0.2");
    options.host = "10.0.0.9";
    options.limits.rate = 0;
  }

  void make_server() { make_server({}); }
  void make_server(support::KnxServer::Options with) {
    server = std::make_unique<support::KnxServer>(time, net, std::move(with));
  }

  void make_line() {
    LineCallbacks calls;
    calls.changed = [this](const LineState& state) { states.push_back(state); };
    calls.failed = [this](Error why) {
      failures.push_back(std::move(why));
      if (reopens) reopening = time.after(reopen_pause, [this] { EXPECT_TRUE(line->open()); });
    };
    calls.received = [this](const wire::Telegram& telegram) { received.push_back(telegram); };
    calls.frame = [this](ByteView cemi, bool outgoing) {
      frames.emplace_back(outgoing, Bytes(cemi.begin(), cemi.end()));
    };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.emplace_back(subject, std::string(text));
    };
    line = std::make_unique<TunnelLine>(options, time, transports, std::move(calls));
  }

  /// Makes a server if there is none, and a line, and waits until it is up.
  void connect() {
    if (!server) make_server();
    make_line();
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
    ASSERT_EQ(phase(), LineState::Phase::kUp) << line->state().reason;
  }

  LineState::Phase phase() const { return line->state().phase; }
  std::uint64_t count(const std::string& name) const { return line->counters().at(name); }

  static wire::Telegram write(std::uint16_t group, Bytes value, bool small = false) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress{group};
    telegram.payload = {std::move(value), small};
    return telegram;
  }

  /// Sends a write of two bytes that carry its number; outcomes[number] gets the result.
  void send(std::uint16_t number, Duration lives = 60s) {
    const Bytes value{static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number & 0xff)};
    send(number, write(0x0a07, value), lives);
  }
  void send(std::uint16_t number, wire::Telegram telegram, Duration lives = 60s) {
    line->send(std::move(telegram), time.now() + lives, [this, number](SendOutcome sent, std::string_view why) {
      EXPECT_FALSE(outcomes.contains(number)) << number << " was reported twice";
      outcomes[number] = {sent, std::string(why)};
      order.push_back(number);
    });
  }
  SendOutcome sent(std::uint16_t number) const {
    EXPECT_TRUE(outcomes.contains(number)) << number;
    return outcomes.contains(number) ? outcomes.at(number).sent : SendOutcome::kExpired;
  }

  /// How often each number reached the bus.
  std::map<std::uint16_t, int> arrivals() const {
    std::map<std::uint16_t, int> times;
    for (const auto& heard : server->heard()) {
      if (heard.tpdu.size() == 4) ++times[static_cast<std::uint16_t>(heard.tpdu[2] << 8 | heard.tpdu[3])];
    }
    return times;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports transports;
  TunnelOptions options;
  std::unique_ptr<support::KnxServer> server;
  std::vector<LineState> states;
  std::vector<Error> failures;
  std::vector<wire::Telegram> received;
  std::vector<std::pair<bool, Bytes>> frames;
  std::vector<std::pair<std::string, std::string>> notes;
  std::map<std::uint16_t, Outcome> outcomes;
  std::vector<std::uint16_t> order;
  bool reopens = true;
  Duration reopen_pause = 500ms;
  Timer reopening;
  std::unique_ptr<TunnelLine> line;
};

}  // namespace rubicon::networks::knx::line
