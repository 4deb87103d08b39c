#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "model/type_catalogue.h"
#include "proxy/device.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::proxy {

/// Reads the clocks once per turn of the loop, however many messages the turn brings.
class TurnClock {
 public:
  explicit TurnClock(Scheduler& scheduler)
      : scheduler_(scheduler), end_of_turn_(scheduler, [this] { fresh_ = false; }) {}
  TurnClock(const TurnClock&) = delete;
  TurnClock& operator=(const TurnClock&) = delete;

  const Moment& now() { return fresh_ ? moment_ : refresh(); }
  /// Timers call this first: the moment of the turn may be older than the time the timer was set for.
  const Moment& refresh();

 private:
  Scheduler& scheduler_;
  Moment moment_{};
  bool fresh_ = false;
  base::OncePerTurn end_of_turn_;
};

/// What every part of the proxy may use. Owned by the Proxy, outlives the parts.
struct ProxyContext {
  const ProxyConfig& config;
  Scheduler& scheduler;
  TupleSpace& space;
  gateway::Gateway& gateway;
  const TypeCatalogue& types;
  Log log;
  Log commands = log;  ///< gets the lines that quote what was set
  TurnClock clock{scheduler};
  base::LimitedLog limited_log{log, scheduler};
  std::uint64_t last_request = 0;

  std::uint64_t next_request() { return ++last_request; }
  /// One warning per subject and minute; the others are discarded.
  void warn(const std::string& subject, std::string_view text) { limited_log.warning(subject, text); }
};

/// Points that one device may have; further ones of a join are refused and counted.
inline constexpr std::size_t kMaxPoints = 1024;

/// The listed devices, their points, and which key part belongs to which address. Uses no tuples.
class DeviceDirectory {
 public:
  explicit DeviceDirectory(ProxyContext& context);

  /// The network with this id. It is created if needed, with default rules where the configuration does not name it.
  Network& network(const std::string& id);
  const std::map<std::string, std::unique_ptr<Network>>& networks() const { return networks_; }

  /// Ids of the networks that have a device with this address: those where it is reachable; if there are none, those
  /// where it was not heard yet; else those where it is unreachable.
  std::vector<std::string> networks_of(const std::string& address) const;

  /// Network and device as in the keys of its tuples, `wsn-1.kitchen`; empty: there is none.
  std::string parts_of(const std::string& network, const std::string& address) const;

  Device* find(DeviceNumber number) const;
  Device* find_by_place(std::uint32_t place) const { return place < places_.size() ? places_[place] : nullptr; }
  /// The device with the key `<prefix>.<parts>`, such as `wsn-1.7`.
  Device* find_by_key(std::string_view parts);

  struct Joined {
    Device* device = nullptr;
    bool fresh = false;           ///< was not listed before
    bool changed = false;         ///< points, capabilities or names differ from before
    std::vector<Point> vanished;  ///< points that the device no longer has
  };
  /// The configuration of the name of a new device is from now on the configuration of its address (naming.h).
  void adopt_names(Network& network, const std::string& address, const std::string& announced);
  /// kBusy at the device cap, kDuplicate if another address has its key.
  Result<Joined> join(Network& network, const std::string& address, const model::Join& join);
  /// True if join() of a device that is not listed would find room and a free key.
  bool has_place(const Network& network, const std::string& address, const std::string& wanted_id) const;

  /// Adds a point for a reading that names no declared one; nullptr if that is impossible.
  Point* add_undeclared(Device& device, const PointId& id);

  void remove(Device& device);

  /// New rules for a network. Call release() before and name() after it for devices whose key or point ids change.
  void configure(Network& network, NetworkRules rules);
  /// Frees the key part of the device, which stays in the directory.
  void release(Device& device);
  /// Gives a released device and its points their ids by the present rules. kDuplicate: the key part is taken, the
  /// device stays released. Returns the points that were removed because their id is taken.
  Result<std::vector<Point>> name(Device& device);
  /// Sets name and area by the present rules; true if one of them changed.
  static bool update_name(Device& device);
  /// Sets what readings of the point must be by the present rules.
  void doubt(const Device& device, Point& point);
  /// The network must have no devices.
  void remove_network(const std::string& id);
  std::size_t size() const { return places_.size() - free_places_.size(); }

 private:
  Result<void> key_is_free(const Network& network, const std::string& id, const std::string& address) const;
  Result<Device*> add(Network& network, const std::string& address, const std::string& wanted_id);
  std::uint32_t take_place(Device& device);
  static bool update_identity(Device& device, const model::Join& join);
  bool reconcile(Device& device, const model::Join& join, std::vector<Point>& vanished);
  Result<Point> make_point(Device& device, const Capability& capability);

  ProxyContext& context_;
  SharedCapabilities capabilities_;
  SharedRules rules_;
  std::map<std::string, std::unique_ptr<Network>> networks_;
  Network* last_network_ = nullptr;
  std::vector<Device*> places_;  ///< by the lower half of DeviceNumber
  std::vector<std::uint32_t> free_places_;
  std::uint32_t joined_ = 0;  ///< devices since the start: the upper half
};

}  // namespace rubicon::proxy
