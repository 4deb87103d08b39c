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
  /// Publishes to `<base>/<name>/<verb>`; the verb is `set` or `get`. kUnreachable without a line, kBusy if its queue
  /// is full.
  virtual Result<void> publish(const std::string& name, std::string_view verb, std::string payload) = 0;
  /// To the island, from this device. Only queues.
  virtual void deliver(const std::string& address, model::Body body) = 0;
  virtual Scheduler& scheduler() = 0;
  /// Whether one more poll fits into the bound of the network (10 a second), and take that place. Devices that find no
  /// place wait in a line: they ask again within 2 s, or lose their place in it.
  virtual bool take_poll(const std::string& address) = 0;
};

// How Zigbee2MQTT 2.14.1 answers (measured; zigbee.md, section 5, differs):
// - A report, or the answer to a get: one state message with a later last_seen and the new values.
// - A set: two messages in either order. One has a later last_seen and no new value: something was heard of the device.
//   The other is the optimistic echo, with the same last_seen. Then comes one message for each attribute that the
//   device reports. If the device does nothing, none comes: only the answer to a get shows the real value.

/// One ZigBee device or group: its points, what its state messages prove (zigbee.md, section 5), its commands until the
/// device confirms them, and the polling that subscribers ask for. Destroying it delivers nothing: call line_lost()
/// before if its requests must be answered.
class Device {
 public:
  /// Delivers the Join. Nothing is published before line_up().
  Device(DeviceHost& host, exposes::PointsOfModels& models, bridge::DeviceRecord record);
  ~Device();

  /// A new record of the same address: a rename, a new definition. Delivers a Join if the device looks different.
  void update(bridge::DeviceRecord record);
  /// A payload of `<base>/<name>`. Empty: the name is gone. `retained`: a stored copy of the broker. kInvalid if it
  /// cannot be read: nothing of it counts then.
  Result<void> state(std::string_view payload, bool retained);
  /// `<base>/<name>/availability`.
  void availability(bool online);
  /// The option `optimistic` of Zigbee2MQTT for this device (bridge/info: devices, device_options); true at first.
  /// False: it publishes no echo of a set, so that the first message with the wanted value is the report.
  void optimistic(bool publishes_echoes);
  /// True: the bridge publishes the availability of this device, and its silence has no limit here. False at first.
  void bridge_decides(bool decides);
  /// Whether a state message may hold a value that Zigbee2MQTT does not repeat.
  bool may_have_event(std::string_view payload) const;
  /// Actuate, SetProperty, Sample, Probe; answers as Network::send does.
  Result<void> send(const Message& message);
  /// The broker is connected (again): it answers no message that was published before.
  void connected();
  /// The broker took the oldest set message that it had not answered. Commands without an echo count as sent: they are
  /// answered kSent.
  void taken();
  /// The broker did not take it: its commands are refused with this reason.
  void not_taken(const std::string& why);
  /// The bridge or the broker is gone, or the device leaves: what waits is answered with this reason; the cached values
  /// stay.
  void line_lost(const std::string& why);
  /// The bridge is there (again): states that follow may be start-up copies.
  void line_up(bool repeats = true);

  const bridge::DeviceRecord& record() const;
  /// Of its state messages: their last_seen, else the arrival of the last live one; zero = none came.
  WallTime last_seen() const;
  const std::vector<exposes::MappedPoint>& points() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::zigbee
