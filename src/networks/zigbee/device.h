#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "network/network.h"
#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/exposes/mapping.h"

namespace rubicon::networks::zigbee {

/// What a device uses of its network. Outlives the device.
class DeviceHost {
 public:
  virtual ~DeviceHost() = default;
  /// Publishes to `<base>/<name>/set` or `/get`.
  virtual Result<void> publish(const std::string& name, std::string_view verb, std::string payload) = 0;
  /// To the island, from this device.
  virtual void deliver(const std::string& address, model::Body body) = 0;
  virtual Scheduler& scheduler() = 0;
  virtual base::LimitedLog& log() = 0;
  /// Whether polls of one more device fit into the bound of the network (10 a second), and take that place.
  virtual bool take_poll() = 0;
};

// How Zigbee2MQTT 2.14.1 answers (measured; zigbee.md, section 5, differs): a report, and the answer to a get, is one
// state message with a later last_seen and the new values. After a set come a message that was only heard (later
// last_seen, nothing else) and the optimistic echo with the same last_seen, in either order, then one message for each
// attribute that the device reports. A device that does nothing sends no further message: only the answer to a get
// shows the real value.

/// One ZigBee device or group: its points, what its state messages prove (zigbee.md, section 5), its commands until the
/// device confirms them, and the polling that subscribers ask for. Destroying it gives pending commands up.
class Device {
 public:
  Device(DeviceHost& host, const TypeCatalogue& types, bridge::DeviceRecord record);
  ~Device();

  /// A new record of the same address: a rename, a new definition. Delivers a Join if the device looks different.
  void update(bridge::DeviceRecord record);
  /// A payload of `<base>/<name>`. Empty: the name is gone. kInvalid if it cannot be read.
  Result<void> state(std::string_view payload, bool retained);
  /// `<base>/<name>/availability`.
  void availability(bool online);
  /// Actuate, SetProperty, Sample, Probe; answers as Network::send does.
  Result<void> send(const Message& message);
  /// The bridge or the broker is gone: what waits is given up with this reason; the cached values stay.
  void line_lost(const std::string& why);
  /// The bridge is there (again): states that follow may be start-up copies.
  void line_up();

  const bridge::DeviceRecord& record() const;
  const std::vector<exposes::MappedPoint>& points() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::zigbee
