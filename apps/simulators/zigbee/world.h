#pragma once

#include <set>
#include <string>
#include <string_view>

#include "apps/simulators/zigbee/bridge_topics.h"
#include "apps/simulators/zigbee/commands.h"
#include "apps/simulators/zigbee/radio.h"
#include "apps/simulators/zigbee/registry.h"
#include "apps/simulators/zigbee/requests.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/result.hpp"

namespace rubicon::zigbee_simulator {

/// A Zigbee2MQTT without radio: devices, groups and the bridge's topics, with the messages, orders and delays that a
/// real one was recorded with (zigbee.md, sections 1 to 8; where the recording differs, as the recording). It publishes
/// by its topics, and takes what clients publish by received().
class World {
 public:
  /// Scheduler and log must outlive it.
  World(WorldOptions options, Scheduler& scheduler, Log log);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // -- its parts
  BridgeTopics& topics() { return topics_; }
  Registry& registry() { return registry_; }
  Radio& radio() { return radio_; }
  const WorldOptions& options() const { return state_.options; }
  const BridgeCounters& counters() const { return state_.counters; }

  // -- the bridge
  /// The bridge begins: state, lists, and the cached state of every device (zigbee.md, section 2).
  void start();
  /// Connected to the broker again: only its state (section 2.4).
  void reconnected();
  /// Says that it is offline, and does nothing until start().
  void stop();
  /// stop(), and start() after this time.
  void restart(Duration pause);
  bool runs() const { return state_.runs; }
  /// A message of a client. Topics that are not the bridge's are ignored.
  void received(std::string_view topic, std::string_view payload);
  /// As by a request; zero ends it.
  void permit_join(Duration span);
  /// An oddity: a list without these devices, and the right one 200 ms later.
  void shrink_list(const std::set<std::string>& addresses);

  // -- devices come and go
  /// A device that was paired long ago, last heard an hour ago. kInvalid: the name is in use or not permitted.
  Result<RadioDevice*> add(DeviceModel model, std::string name = {});
  /// A device begins to pair. It waits until joining is permitted. Its name is its address.
  std::string join(DeviceModel model, bool fails = false);
  void leave(const std::string& address);
  /// The bridge no longer knows it, and says nothing.
  void forget(const RadioDevice& device);
  /// As by a request. kInvalid as add().
  Result<void> rename(RadioDevice& device, const std::string& to);

 private:
  void start_devices();
  void publish_health();
  RadioDevice& keep(DeviceModel model, const std::string& address, const std::string& name);

  BridgeState state_;
  Log log_;
  Registry registry_;
  Delays delays_;
  BridgeTopics topics_;
  Radio radio_;
  Commands commands_;
  Interviews interviews_;
  Requests requests_;
  Timer joining_, health_, restarting_;
};

}  // namespace rubicon::zigbee_simulator
