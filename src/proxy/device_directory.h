#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "proxy/proxy_context.h"
#include "proxy/shared_capabilities.h"

namespace rubicon::proxy {

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

  Device* find(Network& network, const std::string& address);
  Device* find(DeviceNumber number);
  /// The device with the key `<prefix>.<parts>`, such as `wsn-1.7`.
  Device* find_by_key(std::string_view parts);

  struct Joined {
    Device* device = nullptr;
    bool fresh = false;           ///< was not listed before
    bool changed = false;         ///< points, capabilities or names differ from before
    std::vector<Point> vanished;  ///< points that the device no longer has
  };
  /// What the configuration gives to the name of a new device is from now on that of its address (naming.h).
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
  static void doubt(const Device& device, Point& point);
  /// The network must have no devices.
  void remove_network(const std::string& id);
  std::size_t size() const { return by_number_.size(); }

 private:
  Result<void> key_is_free(const Network& network, const std::string& id, const std::string& address) const;
  Result<Device*> add(Network& network, const std::string& address, const std::string& wanted_id);
  static bool update_identity(Device& device, const model::Join& join);
  bool reconcile(Device& device, const model::Join& join, std::vector<Point>& vanished);
  Result<Point> make_point(Device& device, const Capability& capability);

  ProxyContext& context_;
  SharedCapabilities capabilities_;
  std::map<std::string, std::unique_ptr<Network>> networks_;
  Network* last_network_ = nullptr;
  std::unordered_map<DeviceNumber, Device*> by_number_;
  DeviceNumber last_number_ = 0;
};

}  // namespace rubicon::proxy
