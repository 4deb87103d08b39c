#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "proxy/admission/discovery_inbox.h"
#include "proxy/admission/roaming.h"
#include "proxy/memory.h"
#include "proxy/network_tuples.h"

namespace rubicon::proxy::admission {

/// Decides which of the devices that announce themselves the island lists: by what users decided, the configuration,
/// the discovery rules (docs/inbox.md) and the claims of other islands (docs/roaming.md). A device that is not listed
/// is in the inbox, or away with another island.
class Admission {
 public:
  struct Callbacks {
    /// The device is in the directory, for the first time or again: publish it. `known` is what the state file
    /// remembers of it; nullptr = nothing, or it was listed before.
    std::function<void(const DeviceDirectory::Joined&, const Announced&, const state::KnownDevice* known)> listed;
    /// Another island, or network of this one, has the better claim: remove the device. `tuple` is the claim's key.
    std::function<void(Device&, const Claim& to, const std::string& tuple)> moved;
    /// A user ignores the device: remove it.
    std::function<void(Device&)> ignored;
    /// The other island no longer claims the device, and may have stopped its sampling.
    std::function<void(Device&)> unclaimed;
  };
  Admission(ProxyContext& context, DeviceDirectory& directory, Memory& memory, NetworkTuples& network_tuples,
            Callbacks callbacks);

  /// A join of a device of that network; `device` is nullptr if it is not listed.
  void on_join(const Device* device, Network& network, const std::string& address, const model::Join& join);
  /// A message of a device that is not listed. Returns the device if it could be listed now; else the message is
  /// counted, and to be discarded.
  Device* on_unknown_device(Network& network, const Message& message);
  /// The device announced that it left for good: the inbox and Roaming forget it.
  void on_leave(const DeviceName& name);

  /// Lists what the state file remembers of the network (empty: of all).
  void restore(const std::string& network);
  /// The device was admitted and cannot be listed now; it is retried at its next message, and at a reload.
  void defer(const DeviceName& name, const Announced& announced, const std::string& why);
  /// Decides again about all devices in the inbox: the rules may have changed.
  void reevaluate_inbox();
  /// Moves the devices of a network to another domain (empty: none), where others may have the better claim. Devices
  /// that were away in the old domain are decided again.
  void change_domain(Network& network, const std::string& domain);
  void drop_network(const std::string& id);

  /// A remote set of `proxy.inbox` or `proxy.inbox.<network>.<device>`: checked now, carried out in a later turn.
  tuples::SetDecision decide_set(const tuples::RemoteSet& request);

  Roaming& roaming() { return roaming_; }
  const DiscoveryInbox::Counters& inbox_counters() const { return inbox_.counters(); }

 private:
  struct Ruling {
    InboxState state = InboxState::kAdmitted;
    std::string why;
    bool is_admitted() const { return state == InboxState::kAdmitted; }
  };
  Ruling decide(const Network& network, const DeviceName& name, const model::Join& join,
                const state::KnownDevice* known, bool configured) const;
  Ruling decide_usable(const Network& network, const DeviceName& name, const model::Join& join,
                       const state::KnownDevice* known, bool configured) const;
  void keep_out(const DeviceName& name, const Announced& announced, const state::KnownDevice* known, Ruling ruling);
  Device* list(Network& network, const std::string& address, const Announced& announced,
               const state::KnownDevice* known);
  Device* list_unless_claimed(Network& network, const std::string& address, const Announced& announced,
                              const state::KnownDevice* known, bool approved = false);
  Device* retry(Network& network, const DeviceName& name, bool approved = false);
  Device* take_over(const DeviceName& name);
  bool claimed_elsewhere(Network& network, const std::string& address, Device*& device);
  void restore(Network& network, Memory::Row row, state::KnownDevice&& known);
  /// What a user set.
  struct Order {
    state::Decision decision{};
    std::string word;     ///< `approve`, `ignore` or `forget`
    bool many = false;    ///< set `proxy.inbox`, not the tuple of a device
    std::string pattern;  ///< of many devices, or the name of one
  };
  static Result<Order> read_order(const tuples::RemoteSet& request, const std::string& root);
  std::vector<DeviceName> named(const Order& order);
  Result<std::vector<DeviceName>> devices_of(const Order& order);
  std::vector<std::string> inbox_keys(const DeviceName& name);
  Result<std::string> drop_denied(const tuples::RemoteSet& request, std::vector<DeviceName>& devices);
  void apply_decisions();
  void approve(const DeviceName& name);
  void ignore(const DeviceName& name);
  void forget(const DeviceName& name);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Memory& memory_;
  NetworkTuples& network_tuples_;
  Callbacks callbacks_;
  DiscoveryInbox inbox_;
  Roaming roaming_;
  std::vector<std::pair<DeviceName, state::Decision>> decisions_;  ///< of users, accepted and not carried out yet
  base::OncePerTurn next_decisions_;
};

}  // namespace rubicon::proxy::admission
