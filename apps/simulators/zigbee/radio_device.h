#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/simulators/zigbee/definition_generator.h"
#include "apps/simulators/zigbee/device_model.h"

namespace rubicon::zigbee_simulator {

/// How a device misbehaves.
struct Faults {
  bool ignores = false;     ///< accepts a set and does nothing: the echo is wrong, a `get` shows it
  bool refuses = false;     ///< answers a set with an error: it was heard, and there is no echo
  bool silent = false;      ///< no power or out of range: reports nothing, answers nothing
  bool echo_first = false;  ///< the echo of a set comes before the message that the device was heard
  Duration delay{};         ///< before it answers a set or `get`
};

/// A ZigBee device: what it does, and what the bridge knows of it. Sends nothing by itself.
class RadioDevice {
 public:
  using Json = nlohmann::json;

  /// How far its interview is; the record in `bridge/devices` grows with it (trace of a real bridge).
  enum class Stage : std::uint8_t {
    kJoined,
    kEndpoints,
    kModel,
    kManufacturer,
    kPower,
    kDate,
    kInterviewed,
    kConfigured,
    kFailed
  };

  /// `address` with 0x. At first its interview has just begun, and the bridge knows no values.
  RadioDevice(DeviceModel model, std::string address, std::string name, std::uint16_t network_address);

  const std::string& address() const { return address_; }
  const std::string& name() const { return name_; }
  void rename(std::string name);
  const DeviceModel& model() const { return model_; }
  Stage stage() const { return stage_; }
  void set_stage(Stage stage);
  bool usable() const { return stage_ == Stage::kInterviewed || stage_ == Stage::kConfigured; }
  /// As a device that was paired long ago: its interview is over, and the bridge knows all its values.
  void settle(WallTime last_seen);

  /// Its record in `bridge/devices`, as text.
  const std::string& record_text();
  Json record() const;
  Json definition() const { return model_.definition; }

  /// The bridge heard it: a new last_seen and link quality.
  void heard(WallTime now, Random& random);
  WallTime last_seen() const { return last_seen_; }
  /// What the bridge knows: the payload of a state message without last_seen.
  Json known() const;
  /// Its state messages have all properties from now on: null until they are reported.
  void know_nothing();
  void know(const std::string& property, Json value) { known_[property] = std::move(value); }

  /// The part of a set that the bridge sends to the device; TOGGLE is replaced. Null if there is none.
  Json acceptable(const Json& wanted) const;
  /// What the bridge shows at once after it sent this (zigbee.md, section 5); empty = nothing.
  Json echo(const Json& accepted) const;
  /// The device does it: the properties that changed, with those that follow from them.
  std::vector<std::string> execute(const Json& accepted);
  /// The properties of a `get` that can be read.
  std::vector<std::string> readable(const Json& asked) const;

  const Json& real(const std::string& property) const;
  void set_real(const std::string& property, Json value) { real_[property] = std::move(value); }
  /// Measures: each value that walks makes a step.
  void walk(Random& random);
  /// The properties, by cluster: each group is reported in one message.
  std::vector<std::vector<std::string>> by_cluster(const std::vector<std::string>& properties) const;
  /// All properties that it reports by itself each period.
  std::vector<std::string> measured() const;
  /// The bridge takes these properties over from the device.
  void report(const std::vector<std::string>& properties);

  Faults faults;
  Json waiting = Json::object();  ///< of a sleeping device: what was set since it last woke
  std::uint64_t messages = 0;     ///< that the bridge heard
  bool joined = false;            ///< the bridge has it in its list
  bool online = true;             ///< availability
  Duration every{};               ///< between two reports of what it measures; 0 = none
  Json options = Json::object();  ///< in the configuration of the bridge

 private:
  Json follows(const Json& accepted) const;

  DeviceModel model_;
  std::string address_, name_;
  std::uint16_t network_address_;
  Stage stage_ = Stage::kJoined;
  Json real_, known_ = Json::object();
  WallTime last_seen_{};
  int link_quality_ = -1;  ///< -1 = not known yet
  std::string text_;       ///< of the record; empty = has changed
};

}  // namespace rubicon::zigbee_simulator
