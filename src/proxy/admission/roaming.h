#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proxy/admission/discovery_inbox.h"
#include "proxy/admission/roaming_claims.h"
#include "proxy/device_directory.h"

namespace rubicon::proxy::admission {

/// Decides which island of a roaming domain lists a device that several of them hear (docs/roaming.md, decision 008).
/// Claims what this island lists, gives up what another claimant has the better claim to, and takes over devices that
/// joined here. Networks without a domain are ignored.
class Roaming {
 public:
  struct Callbacks {
    /// The other claim is better: the device must leave the directory at once. `tuple` is the key of the other claim.
    std::function<void(Device&, const Claim& other, const std::string& tuple)> moved;
    /// The join of an away device is now in effect: take() it and list it.
    std::function<void(const DeviceName&)> arrived;
    /// The other island no longer claims the device, and may have stopped its sampling.
    std::function<void(Device&)> unclaimed;
  };
  Roaming(ProxyContext& context, DeviceDirectory& directory, Callbacks callbacks);

  /// Call when networks or their domains changed.
  void follow_domains();
  /// The time of a join received now: later than every join that other islands know.
  WallTime join_time(const Network& network, const std::string& address) const;

  /// Whether another claimant lists the device. If so, it is kept as away, and `arrived` follows if it may be taken
  /// over. `approved`: a user approved it just now.
  bool defers(const Network& network, const std::string& address, const Announced& announced, bool approved = false);
  /// The device was admitted or approved here before and has been with other claimants since.
  bool trusts(const DeviceName& name) const;

  enum class Whereabouts { kUnknown, kElsewhere, kReturned };
  /// A message of a device that is not in the directory. kReturned: no other claimant lists it; take() it.
  Whereabouts on_message(const Network& network, const std::string& address);
  /// What an away device last announced. From now on it is not away: list it or drop it.
  std::optional<Announced> take(const DeviceName& name);

  /// The device was listed, joined again, became reachable or unreachable, or got another key.
  void publish_claim(Device& device);
  /// The device leaves the directory.
  void withdraw_claim(const Device& device);
  /// The device announced that it left for good.
  void forget(const DeviceName& name);
  /// The network has another domain now: claims all its devices there.
  void enter_domain(const Network& network);
  /// The network is removed or leaves its domain; its claims must be withdrawn. Returns its devices that are away.
  std::map<DeviceName, Announced> drop_network(const std::string& id);

  RoamingClaims& claims() { return claims_; }
  /// The device of an own claim; nullptr = none. Sets `identity` if the tuple is an own claim.
  Device* device_of_claim(const std::string& tuple, const Identity*& identity);

 private:
  /// A device that this island deferred or lost to another claimant, or listed again after that.
  struct AwayDevice {
    Announced announced;
    bool is_away = false;  ///< false: listed here again
    bool trusted = false;  ///< admitted before, or approved
    bool by_join = false;  ///< the decision that is due follows from a join, not from another message
    SteadyTime asked_at{};
    Timer decision;
    unsigned takeovers = 0;  ///< by other claimants, in a row, while both heard the device
    SteadyTime lost_at{};
  };
  struct OwnClaim {
    DeviceNumber device = 0;
    WallTime since{};
    SteadyTime renewed_at{};  ///< when `since` changed
  };
  /// Another island, or another network of this island, that lists a device.
  struct Claimant {
    Claim claim;
    SteadyTime renewed_at{};
  };

  static Identity identity_of(const Network& network, const std::string& address) {
    return {network.rules.roaming, address};
  }
  Device* own_device(const Identity& identity);
  std::vector<Claimant> claimants(const Identity& identity, const Network& network) const;
  AwayDevice& remember(const DeviceName& name, const Announced& announced);
  void schedule_decision(const DeviceName& name, AwayDevice& away, bool by_join);
  void decide(const DeviceName& name);
  void on_claimed(const Identity& identity);
  void on_unclaimed(const Identity& identity);
  void give_up(Device& device, const Claim& to, const std::string& tuple);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Callbacks callbacks_;
  RoamingClaims claims_;
  std::map<DeviceName, AwayDevice> away_;
  std::map<Identity, OwnClaim> own_;
};

}  // namespace rubicon::proxy::admission
