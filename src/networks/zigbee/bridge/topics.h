#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/compare_text.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::bridge {

/// Why no device or group may get this friendly name: name_problem(), or something else has the same topics:
/// `bridge/...` of the bridge; `a/set`, `a/get/b` and `a/availability` of a device `a`, which may come later. Empty if
/// it may.
std::string new_name_problem(std::string_view name);

/// The topics of one bridge and of its devices and groups. Friendly names may contain slashes: a topic is never split,
/// it is looked up (zigbee.md, section 1).
class Topics {
 public:
  enum class Kind : std::uint8_t {
    kBridgeState,
    kInfo,
    kDevices,
    kGroups,
    kEvent,
    kHealth,
    kResponse,
    kState,
    kAvailability
  };
  struct Found {
    Kind kind = Kind::kState;
    std::string_view entity;  ///< kState, kAvailability: address of the device or group; valid until it is changed
    std::string_view what;    ///< kResponse: which request, `device/rename`; part of the topic
  };
  /// Filters that are to be subscribed to, or no longer.
  struct Filters {
    std::vector<std::string> added, removed;
  };

  /// kInvalid for a base topic that is empty, longer than 200 bytes, no UTF-8, or has wildcards, control characters or
  /// a slash at an end.
  static Result<void> check_base(std::string_view base);
  explicit Topics(std::string base);

  /// A new device or group, or a new name of one.
  Filters put(const std::string& address, const std::string& name);
  Filters remove(const std::string& address);
  /// nullopt: the topic belongs to no known device or group. The payload decides if a topic has two meanings: the state
  /// of the device `a/availability`, and the availability of `a`.
  std::optional<Found> find(std::string_view topic, std::string_view payload) const;
  /// Why a name cannot be used: something else has the same topics (`bridge/state`, or `a/set` where there is a device
  /// `a`). Empty = usable. Messages to such a topic are not the state of the device.
  std::string conflict(const std::string& address) const;

  /// All filters: the bridge's own topics and those of the entities. After each connect.
  std::vector<std::string> filters() const;
  const std::string& base() const { return base_; }
  std::string state(std::string_view name) const;  ///< `<base>/<name>`
  std::string set(std::string_view name) const { return state(name) + "/set"; }
  std::string get(std::string_view name) const { return state(name) + "/get"; }
  std::string availability(std::string_view name) const { return state(name) + "/availability"; }
  /// `<base>/bridge/request/<what>`
  std::string request(std::string_view what) const { return bridge_ + "request/" + std::string(what); }

 private:
  struct Meaning {
    std::string address;
    Kind kind = Kind::kState;
  };
  void add(const std::string& topic, const std::string& address, Kind kind, Filters& filters);
  /// conflict() of an entity with this name.
  std::string name_conflict(std::string_view name) const;
  void drop(const std::string& topic, const std::string& address, Kind kind, Filters& filters);

  std::string base_, bridge_;                           ///< `<base>`, `<base>/bridge/`
  std::map<std::string, Kind, std::less<>> own_;        ///< the bridge's topics
  base::ByText<std::vector<Meaning>> table_;            ///< of the entities; the newest meaning last
  std::unordered_map<std::string, std::string> names_;  ///< address -> name
};

}  // namespace rubicon::networks::zigbee::bridge
