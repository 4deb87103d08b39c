#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "support/memory/mqtt_broker.h"
#include "transport/mqtt_queue.h"

namespace rubicon::transport {

/// One connection to an MqttBroker: what its line and the broker know of it. Lives until the last of both forgets it.
struct MemorySession {
  MemorySession(MqttOptions of, MqttCalls to) : options(std::move(of)), calls(std::move(to)) {}

  // the line's side
  MqttOptions options;
  MqttCalls calls;
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
  std::map<std::string, std::uint8_t> filters;
  Timer silence;
};

/// For MemoryTransports: as Transports::open_mqtt.
Result<std::unique_ptr<MqttLine>> open_memory_mqtt(MemoryNet& net, const MqttOptions& options, MqttCalls calls);

/// Tells the line in a later turn, once.
void lose(MemoryNet& net, const std::shared_ptr<MemorySession>& session, Error why);

}  // namespace rubicon::transport
