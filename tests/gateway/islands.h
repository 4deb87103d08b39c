#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "gateway/gateway.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::gateway {

using namespace std::chrono_literals;
using model::Acknowledge;
using model::Opaque;
using model::Outcome;

inline const model::PointId kLamp{Kind::kActuator, TypeId{0x8001}, "1"};
inline const model::PointId kMeter{Kind::kSensor, TypeId{0x8002}, "1"};

/// A network that keeps what it is sent and answers with an error where a test wants one.
class PlayedNetwork final : public network::Network {
 public:
  explicit PlayedNetwork(network::NetworkHost& a_host) : host(a_host) {}
  Result<void> open() override { return {}; }
  Result<void> send(const Message& message) override {
    sent.push_back(message);
    if (!why.text.empty()) return fail(why);
    return {};
  }
  void say(const std::string& device, model::Body body) { host.deliver(device, std::move(body)); }
  /// From a device to any address.
  void say_to(const std::string& device, Address to, model::Body body);

  network::NetworkHost& host;
  std::vector<Message> sent;
  Error why;
};

/// One island of a test: a component, its gateway, and networks `a` and `b`.
struct Island {
  Island(std::uint32_t number, VirtualScheduler& time, tuples::MemoryEcology& ecology, base::LogSink& log,
         GatewayLimits limits = {});
  PlayedNetwork& network(const std::string& id) { return *played.at(id); }
  /// All messages that local listeners got, of all kinds.
  std::vector<Message> heard_of(MessageKind kind) const;
  std::vector<Acknowledge> answers() const;
  void listen(MessageKind kind);
  /// A message from this island's own components.
  void send(Address to, model::Body body);
  Address address(const std::string& network = {}, const std::string& device = {}) const {
    return {space.self(), network, device};
  }

  std::map<std::string, PlayedNetwork*> played;
  transport::MemoryTransports files;
  TypeCatalogue types;
  std::unique_ptr<tuples::Link> link;
  TupleSpace space;
  Gateway gateway;
  network::Supervisor networks;
  std::vector<Handle> handles;
  std::vector<Message> heard;
};

/// Three islands, each of which listens to acknowledgements.
class Islands : public ::testing::Test {
 protected:
  Islands() {
    for (Island* island : {&one, &two, &three}) island->listen(MessageKind::kAcknowledge);
  }

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  support::CollectingLog log;
  GatewayLimits limits{100, 20};
  Island one{1, time, ecology, log, limits};
  Island two{2, time, ecology, log, limits};
  Island three{3, time, ecology, log, limits};
};

inline Opaque note(const std::string& text, const std::string& type = "note") {
  return {type, Bytes(text.begin(), text.end())};
}
std::string text_of(const Message& message);
std::vector<std::string> texts_of(const std::vector<Message>& messages);
model::Updates reading(std::int64_t value, std::size_t count = 1);

}  // namespace rubicon::gateway
