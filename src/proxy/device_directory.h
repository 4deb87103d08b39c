#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "proxy/proxy_context.h"
#include "proxy/shared_capabilities.h"

namespace rubicon::proxy {

/// Most points one device may have; more in a join are refused and counted.
inline constexpr std::size_t kMaxPoints = 1024;

/// Which devices there are, what they can do, and which key part belongs to which address. Knows nothing of tuples.
class DeviceDirectory {
 public:
  explicit DeviceDirectory(ProxyContext& context);

  /// The network with this id; one that the configuration does not name gets the default rules.
  Network& network(const std::string& id);
  const std::map<std::string, std::unique_ptr<Network>>& networks() const { return networks_; }

  /// Ids of the networks that have a device with this address: of those that reach it; else of those where it was not
  /// heard yet; else of those that lost it.
  std::vector<std::string> networks_of(const std::string& address) const;

  Device* find(Network& network, const std::string& address);
  Device* find(DeviceNumber number);
  /// The device with the key `<prefix>.<parts>`, such as `wsn-1.7`.
  Device* find_by_key(std::string_view parts);

  struct Joined {
    Device* device = nullptr;
    bool fresh = false;           ///< it was not known before
    bool changed = false;         ///< points, capabilities or names differ from what they were
    std::vector<Point> vanished;  ///< points it had and has no more
  };
  /// kBusy at the device cap, kDuplicate if another address has its key.
  Result<Joined> join(Network& network, const std::string& address, const model::Join& join);
  /// join() of a device that is not here would find room and a free key.
  bool has_place(const Network& network, const std::string& address, const std::string& wanted_id) const;

  /// A point made by a value that arrived for it; nullptr if it cannot be.
  Point* add_undeclared(Device& device, const PointId& id);

  void remove(Device& device);

  /// New rules for a network. The devices whose key or point ids follow from them must have been released before, and
  /// are named again after.
  void configure(Network& network, NetworkRules rules);
  /// Frees the device's key part; the device stays, without a name.
  void release(Device& device);
  /// Gives a released device and its points the ids that the present rules say. kDuplicate: its key part is taken; it
  /// stays released. Points whose id is taken are moved out and returned.
  Result<std::vector<Point>> name(Device& device);
  /// The name for people by the present rules; true if it is another one now.
  static bool take_name(Device& device);
  /// Forgets a network without devices.
  void remove_network(const std::string& id);
  std::size_t size() const { return by_number_.size(); }

 private:
  Result<void> key_is_free(const Network& network, const std::string& id, const std::string& address) const;
  Result<Device*> add(Network& network, const std::string& address, const std::string& wanted_id);
  static bool take_identity(Device& device, const model::Join& join);
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
