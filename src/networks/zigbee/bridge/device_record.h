#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/shared_list.h"
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
  std::string address;        ///< the ieee_address without `0x`: 16 hex digits, lower case. Of a group: `group-<id>`
  std::string name;           ///< friendly name: the part of the topics; cut after kMaxTextBytes
  std::string unusable_name;  ///< name_problem() of it
  Role role = Role::kUnknown;
  Interview interview = Interview::kPending;
  bool supported = false, disabled = false;
  std::string vendor, model;  ///< of the definition; else as the device names them
  std::string description;    ///< what the user wrote about the device, else the definition's
  std::string firmware;
  std::string power_source;  ///< as written: `Battery`, `Mains (single phase)`; empty = not known yet
  base::SharedList<exposes::Leaf> leaves;
  std::vector<std::string> skipped;       ///< what of `exposes` is not a leaf
  base::SharedList<std::string> options;  ///< what the bridge can be told to do with it: JSON of each
  std::vector<Reporting> reportings;

  /// Has a power source other than a battery, or is a router without a known one: it can be polled (zigbee.md, section
  /// 6).
  bool mains() const;
  /// A group of devices (bridge/groups.h), not a device: `group-<id>`.
  bool is_group() const { return address.starts_with("group-"); }
  friend bool operator==(const DeviceRecord&, const DeviceRecord&) = default;
};

/// Longest record that is read. The largest of 4,516 definitions has 63 KB; a record is read in one turn, and one of
/// this size can take 5 ms.
inline constexpr std::size_t kMaxRecordBytes = std::size_t{128} * 1024;

/// Further options of a definition are left out.
inline constexpr std::size_t kMaxOptions = 200;

/// `0x00124B0010000000` -> `00124b0010000000`; empty if it is not an ieee_address.
std::string address_of(std::string_view ieee);
/// The other direction, for requests to the bridge.
std::string ieee_of(std::string_view address);
/// Why a friendly name cannot be part of a topic (zigbee.md, section 1; at most 512 bytes of UTF-8, 90
/// levels); empty if it can.
std::string name_problem(std::string_view name);

/// Why a device or group cannot be used, and what the user can do; empty if it can be used.
std::string why_waiting(const DeviceRecord& record);

/// kInvalid names what is wrong; a record needs an ieee_address of `0x` and 16 hex digits.
Result<DeviceRecord> read_device_record(std::string_view json);

}  // namespace rubicon::networks::zigbee::bridge
