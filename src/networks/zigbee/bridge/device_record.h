#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "networks/zigbee/exposes/leaf.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::bridge {

enum class Role : std::uint8_t { kCoordinator, kRouter, kEndDevice, kUnknown };
enum class Interview : std::uint8_t { kPending, kInProgress, kSuccessful, kFailed };

/// One configured reporting of an attribute (zigbee.md, section 3).
struct Reporting {
  std::string cluster, attribute;
  std::uint32_t minimum_seconds = 0, maximum_seconds = 0;
  friend bool operator==(const Reporting&, const Reporting&) = default;
};

/// A record of `bridge/devices` (zigbee.md, section 3). Unknown keys are ignored; absent and null are alike.
struct DeviceRecord {
  std::string address;  ///< the ieee_address without `0x`: 16 hex digits, lower case. Of a group: `group-<id>`
  std::string name;     ///< friendly name: the part of the topics
  Role role = Role::kUnknown;
  Interview interview = Interview::kPending;
  bool supported = false, disabled = false;
  std::string vendor, model, description, firmware;
  std::string power_source;  ///< as written: `Battery`, `Mains (single phase)`; empty = not known yet
  std::vector<exposes::Leaf> leaves;
  std::vector<std::string> skipped;  ///< what of `exposes` is no leaf
  std::vector<Reporting> reportings;

  /// Has a power source other than a battery, or is a router without a known one: it can be polled (zigbee.md, section
  /// 6).
  bool mains() const;
  /// A group of devices (bridge/groups.h), not a device: `group-<id>`.
  bool is_group() const { return address.starts_with("group-"); }
  friend bool operator==(const DeviceRecord&, const DeviceRecord&) = default;
};

/// kInvalid names what is wrong; a record needs an ieee_address of `0x` and 16 hex digits, and a friendly name.
Result<DeviceRecord> read_device_record(std::string_view json);

}  // namespace rubicon::networks::zigbee::bridge
