#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "support/memory/mqtt_broker.h"
#include "transport/mqtt_exchange.h"

namespace rubicon::transport {

/// What a broker has for a client.
struct MemoryPacket {
  std::function<void()> arrive;
  bool counts = false;  ///< against the bound of what waits: all messages but retained ones of QoS 0
  std::uint8_t qos = 0;
  std::optional<SteadyTime> expires{};
};

/// One connection to an MqttBroker: what its line and the broker know of it. Lives until the last of both forgets it.
struct MemorySession {
  MemorySession(MqttOptions of, MqttCallbacks to) : options(std::move(of)), calls(std::move(to)) {}

  // the line's side
  MqttOptions options;
  MqttCallbacks calls;
  std::string name;
  MqttCounters counters;
  MqttOutQueue queue;
  std::deque<std::function<void(const std::shared_ptr<MemorySession>&)>> asked;  ///< subscriptions that wait, in order
  std::unique_ptr<Lookup> lookup;
  Timer deadline;  ///< of the connection
  bool alive = true, connected = false, lost = false, flushing = false;

  // the broker's side
  MqttBroker* broker = nullptr;  ///< once reached, until it is lost
  bool accepted = false;
  bool version_5 = true;
  Duration keep_alive{};
  std::map<std::string, std::uint8_t> filters;
  bool stalled = false;
  Duration reads_each{};              ///< takes a message each so long; zero = at once
  std::deque<MemoryPacket> backlog;   ///< what it does not read
  std::size_t in_flight = 0;          ///< messages of QoS 1 that it did not acknowledge yet
  Timer silence, half_open, reading;  ///< of the line; of the broker; until it takes the next message
};

/// For MemoryTransports: as Transports::open_mqtt.
Result<std::unique_ptr<MqttLine>> open_memory_mqtt(MemoryNet& net, const MqttOptions& options, MqttCallbacks calls);

/// Tells the line in a later turn, once.
void lose(MemoryNet& net, const std::shared_ptr<MemorySession>& session, Error why);

}  // namespace rubicon::transport
