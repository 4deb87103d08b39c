#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "proxy/device_directory.h"
#include "proxy/discovery_inbox.h"
#include "proxy/roaming_claims.h"

namespace rubicon::proxy {

/// Which of the islands of a domain lists a device that several hear (docs/roaming.md, decision 008): claims what this
/// island lists, gives up what another has the better claim to, and takes over who joined here. Networks without a
/// domain are no concern of it.
class Roaming {
 public:
  struct Calls {
    /// The other claim is better: the device must leave the directory at once. `tuple` is the other claim's key.
    std::function<void(Device&, const Claim& other, const std::string& tuple)> moved;
    /// A device whose join was held back comes now: take() it and list it.
    std::function<void(const DeviceName&)> arrives;
    /// The island that had the device let it go, and may have told it to stop.
    std::function<void(Device&)> alone;
  };
  Roaming(ProxyContext& context, DeviceDirectory& directory, Calls calls);

  /// The networks and their domains changed.
  void follow();
  /// The time of a join heard now: newer than every join another island knows of.
  WallTime stamp(const Network& network, const std::string& address) const;

  /// True: another one lists the device, which is remembered and arrives, or not, as the rules say.
  /// `approved`: by a user, a moment ago.
  bool holds_back(const Network& network, const std::string& address, const Announced& announced,
                  bool approved = false);

  /// Was let in before, or approved, and has been with others since.
  bool trusts(const DeviceName& name) const;

  enum class Heard { kUnknown, kElsewhere, kReturns };
  /// A device that is not in the directory said something. kReturns: nobody else lists it any more; take() it.
  Heard heard(const Network& network, const std::string& address);
  /// What a device that arrives or returns last announced; it must be listed now, or is not known here any more.
  std::optional<Announced> take(const DeviceName& name);

  /// Listed, joined again, became reachable or unreachable, or got another key.
  void listed(Device& device);
  /// Goes out of the directory.
  void withdrawn(const Device& device);
  /// It said that it is gone for good.
  void forget(const DeviceName& name);
  /// The network has another domain now.
  void enter_domain(const Network& network);
  /// The network goes, or its domain does. Its devices must be withdrawn. Returns those it
  /// held back.
  std::map<DeviceName, Announced> drop_network(const std::string& id);

  RoamingClaims& claims() { return claims_; }
  /// The device that one of our claim tuples stands for; nullptr = none.
  Device* meant_by(const std::string& tuple, const Identity*& identity);

 private:
  /// A device that this island knows and has lost to another one, or listed again after that.
  struct Rover {
    Announced announced;
    bool away = false;     ///< not listed here
    bool trusted = false;  ///< let in before, or approved
    bool by_join = false;
    SteadyTime asked_at{};
    Timer decision;
    unsigned losses = 0;  ///< in a row, while both heard it
    SteadyTime lost_at{};
  };
  struct Own {
    DeviceNumber device = 0;
    WallTime since{};
    SteadyTime renewed_at{};  ///< when since changed
  };
  /// One that lists a device: another island, or another network of this one.
  struct Holder {
    Claim claim;
    SteadyTime renewed_at{};
  };

  static Identity identity_of(const Network& network, const std::string& address) {
    return {network.rules.roaming, address};
  }
  std::vector<Holder> holders(const Identity& identity, const Network& network) const;
  Rover& remember(const DeviceName& name, const Announced& announced);
  void ask(const DeviceName& name, Rover& rover, bool by_join);
  void decide(const DeviceName& name);
  void claimed(const Identity& identity);
  void ceased(const Identity& identity);
  void give_up(Device& device, const Claim& to, const std::string& tuple);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Calls calls_;
  RoamingClaims claims_;
  std::map<DeviceName, Rover> rovers_;
  std::map<Identity, Own> own_;
};

}  // namespace rubicon::proxy
