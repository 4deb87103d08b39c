#pragma once

#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "rubicon/tuple_space.hpp"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "support/memory/mqtt_broker.h"
#include "tuples/component.h"
#include "tuples/mqtt/mqtt_ecology.h"

namespace rubicon::tuples::mqtt {

inline const transport::Endpoint kBroker{"10.0.0.1", 1883};
constexpr OwnerId kHall{1}, kLab{2}, kRobot{70000};

/// Options of a process that takes part at that broker, and at others while it is away.
inline SpaceOptions options_at(const std::vector<transport::Endpoint>& brokers) {
  SpaceOptions options;
  for (const auto& at : brokers) {
    options.brokers.emplace_back().line.host = at.address;
    options.brokers.back().line.port = at.port;
  }
  options.trust_broker = true;
  return options;
}

/// Text that packing makes no smaller than three quarters.
inline std::string noise(std::size_t size) {
  std::mt19937 random(static_cast<unsigned>(size));
  std::string text(size, '\0');
  for (auto& letter : text) letter = static_cast<char>('0' + random() % 64);
  return text;
}

/// A process with one component, at its own site.
struct Site {
  Site(VirtualScheduler& scheduler, transport::MemoryNet& net, OwnerId id, const std::string& address,
       const SpaceOptions& options)
      : time(scheduler) {
    machine.join(net, address);
    ecology =
        std::move(*MqttEcology::open(options, time, machine, log, [this] { return time.now().time_since_epoch(); }));
    ecology->watch_displaced([this](OwnerId one) { displaced.push_back(one); });
    link = std::move(*ecology->join(id));
    space = std::make_unique<TupleSpace>(id, time, *link);
    peers = space->watch_peers([this](OwnerId peer, PeerEvent event) {
      const auto* what = event == PeerEvent::kUp ? "up " : event == PeerEvent::kLeft ? "left " : "lost ";
      events.push_back(what + std::to_string(number(peer)));
    });
  }
  std::vector<std::string> take() { return std::exchange(events, {}); }
  std::string value(OwnerId owner, std::string_view key) const {
    const auto found = space->get(owner, key);
    return found ? std::string(found->value) : "none";
  }

  VirtualScheduler& time;
  transport::MemoryTransports machine;
  support::CollectingLog log;
  std::unique_ptr<MqttEcology> ecology;
  std::unique_ptr<Link> link;
  std::unique_ptr<TupleSpace> space;
  std::vector<OwnerId> displaced;
  std::vector<std::string> events;
  Handle peers;
};

}  // namespace rubicon::tuples::mqtt
