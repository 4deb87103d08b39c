#pragma once

#include <gtest/gtest.h>

#include "networks/knx/line/host.h"
#include "networks/knx/line/routing_line.h"

namespace rubicon::networks::knx::line {

using namespace std::chrono_literals;

inline const std::string kGroup(kKnxGroup);

inline wire::Telegram write_to(std::uint16_t group, Bytes value = {0x0c, 0x33}) {
  wire::Telegram telegram;
  telegram.destination = wire::GroupAddress(group);
  telegram.payload = {std::move(value), false};
  return telegram;
}

/// A routing line of a host, and everything it reports.
struct Router {
  Router(VirtualScheduler& t, Host& host, RoutingOptions options = {}) : time(t) {
    LineCallbacks calls;
    calls.changed = [this](const LineState& state) { states.push_back(state); };
    calls.failed = [this](Error error) { failures.push_back(std::move(error)); };
    calls.received = [this](const wire::Telegram& telegram) { received.push_back(telegram); };
    calls.frame = [this](ByteView cemi, bool outgoing) { frames.emplace_back(base::to_hex(cemi), outgoing); };
    RoutingCallbacks more;
    more.lost = [this](const Endpoint& from, const wire::RoutingLostMessage& message) {
      losses.emplace_back(from.address, message.lost);
    };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.emplace_back(subject, std::string(text));
    };
    more.discovery = [this](const Endpoint& from, ByteView frame) { searches.emplace_back(from, base::to_hex(frame)); };
    if (options.interface_address.empty()) options.interface_address = host.at;
    if (options.interface_address == "any") options.interface_address.clear();
    line = std::make_unique<RoutingLine>(time, host.lines, std::move(options), std::move(calls), std::move(more));
  }
  void send(wire::Telegram telegram, Duration lives = 5s) {
    line->send(std::move(telegram), time.now() + lives, [this](SendOutcome outcome, std::string_view) {
      outcomes.push_back(outcome);
      times.push_back(time.now());
    });
  }

  VirtualScheduler& time;
  std::vector<LineState> states;
  std::vector<Error> failures;
  std::vector<wire::Telegram> received;
  std::vector<std::pair<std::string, bool>> frames;
  std::vector<std::pair<std::string, int>> losses;
  std::vector<std::pair<Endpoint, std::string>> searches;
  std::vector<std::pair<std::string, std::string>> notes;
  std::vector<SendOutcome> outcomes;
  std::vector<SteadyTime> times;
  std::unique_ptr<RoutingLine> line;
};

class RoutingOverMemory : public ::testing::Test {
 protected:
  void SetUp() override { other.listen({kGroup}, kKnxPort); }
  void open(Router& router) {
    ASSERT_TRUE(router.line->open());
    time.run_for(1s);
  }
  void from_other(std::string_view hex) {
    other.send({kGroup, kKnxPort}, bytes(hex));
    time.run_for(1ms);
  }
  void busy(std::string_view wait = "0064", std::string_view control = "0000") {
    from_other("06100532000c0600" + std::string(wait) + std::string(control));
  }
  std::vector<Duration> pauses(const Router& router) {
    std::vector<Duration> all;
    for (std::size_t i = 1; i < router.times.size(); ++i) all.push_back(router.times[i] - router.times[i - 1]);
    return all;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  Host here{net, "10.77.0.2"}, other{net, "10.77.0.3"};
};

}  // namespace rubicon::networks::knx::line
