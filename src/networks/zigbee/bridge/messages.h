#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

// What a bridge publishes below `<base>/bridge/` besides the list of devices (zigbee.md, sections 1, 4, 7 and 8).
// Unknown keys are ignored; absent and null are alike. Each reader returns kInvalid, with the topic, for what is no
// JSON, is nested too deep or is longer than kMaxMessageBytes.
namespace rubicon::networks::zigbee::bridge {

/// Longest payload of these topics. bridge/info of 1,000 devices has about 150 KB, a network map of them 2 MB.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{4} * 1024 * 1024;

/// `bridge/state` and `<name>/availability`: true = online. Also the bare words `online` and `offline` of older
/// versions. kInvalid for everything else, also for the empty payload with which a topic ends (rename, removal).
Result<bool> read_online(std::string_view payload);

/// Options of one device or group in the configuration of the bridge; absent = as for all.
struct EntityOptions {
  std::optional<bool> optimistic;    ///< false: a set is not echoed before the device reports
  std::optional<bool> availability;  ///< whether `<name>/availability` is published
  std::optional<bool> retain{};      ///< the broker keeps the last state message
  friend bool operator==(const EntityOptions&, const EntityOptions&) = default;
};

/// `bridge/info`: the bridge and those of its settings that matter to us.
struct BridgeDescription {
  std::string version;              ///< `2.14.1`
  std::string coordinator;          ///< type: `EZSP v13`
  std::string coordinator_address;  ///< 16 hex digits; empty = not given
  std::uint32_t channel = 0;        ///< 11..26; 0 = not given
  bool permit_join = false;
  WallTime permit_join_end{};  ///< when it closes by itself; zero = not given
  bool restart_required = false;

  std::string output = "json";              ///< advanced.output: `json`, `attribute`, `attribute_and_json`
  std::string last_seen = "disable";        ///< advanced.last_seen: `disable`, `ISO_8601`, `ISO_8601_local`, `epoch`
  std::string log_level = "info";           ///< advanced.log_level
  bool cache_state = true;                  ///< advanced.cache_state: a state message has all properties
  bool retained = true;                     ///< false: mqtt.force_disable_retain, no list is kept by the broker
  bool availability_enabled = false;        ///< availability.enabled
  EntityOptions all;                        ///< device_options
  std::map<std::string, EntityOptions> of;  ///< by address, as DeviceRecord::address; only those that have options

  bool last_seen_published() const { return last_seen != "disable"; }
  /// Whether the bridge echoes a set to this device or group before the device reports.
  bool optimistic(const std::string& address) const;
  /// Whether the bridge publishes the availability of this device or group.
  bool availability(const std::string& address) const;
  friend bool operator==(const BridgeDescription&, const BridgeDescription&) = default;
};
Result<BridgeDescription> read_info(std::string_view payload);

/// kUnsupported with the reason for versions before 2, and if the version cannot be read.
Result<void> check_version(const BridgeDescription& info);

/// `bridge/event`. It only makes things faster: the list of devices is the truth.
struct BridgeEvent {
  enum class Kind : std::uint8_t { kJoined, kInterviewing, kInterviewed, kFailed, kAnnounced, kLeft, kOther };
  Kind kind = Kind::kOther;
  std::string type;                        ///< as written: `device_joined`
  std::string address;                     ///< 16 hex digits; always there unless kOther
  std::string name;                        ///< friendly name
  std::string vendor, model, description;  ///< of kInterviewed; empty = not known
  bool supported = false;                  ///< of kInterviewed
  friend bool operator==(const BridgeEvent&, const BridgeEvent&) = default;
};
/// `joined`, `interviewing`, `interviewed`, `failed`, `announced`, `left`, `other`.
std::string_view to_string(BridgeEvent::Kind kind);
/// A type that is not known is kOther. kInvalid if a known one has no address.
Result<BridgeEvent> read_event(std::string_view payload);

/// `bridge/response/<what>`.
struct BridgeResponse {
  bool ok = false;
  std::string error;        ///< the bridge's own text, on one line; empty if ok
  std::string transaction;  ///< of the request; empty = none
  std::string data;         ///< a JSON object, as text
  friend bool operator==(const BridgeResponse&, const BridgeResponse&) = default;
};
Result<BridgeResponse> read_response(std::string_view payload);

/// The data of `bridge/response/networkmap` for a request {"type":"raw"}.
struct NetworkMap {
  struct Node {
    std::string address, name, role, vendor, model;
    std::vector<std::string> failed;  ///< which questions the device did not answer: `lqi`, `routingTable`
  };
  struct Link {
    std::string source, target;  ///< addresses; the source hears the target
    std::uint32_t quality = 0;   ///< 0..255
    std::uint32_t depth = 0;
    std::string relation;  ///< `parent`, `child`, `sibling`, `none`, `previous child`; empty = not known
  };
  std::vector<Node> nodes;
  std::vector<Link> links;
};
Result<NetworkMap> read_network_map(std::string_view data);

/// `bridge/health`, every 10 minutes.
struct BridgeHealth {
  struct Device {
    std::uint64_t messages = 0, leaves = 0, address_changes = 0;
    double messages_per_second = 0;
  };
  WallTime time{};  ///< when it was made; zero = not given
  double load = 0;  ///< of the host, over one minute
  double host_memory_percent = 0, memory_mb = 0, uptime_seconds = 0;
  bool mqtt_connected = false;
  std::uint64_t mqtt_queued = 0, mqtt_published = 0, mqtt_received = 0;
  std::map<std::string, Device> devices;  ///< by address
};
Result<BridgeHealth> read_health(std::string_view payload);

}  // namespace rubicon::networks::zigbee::bridge
