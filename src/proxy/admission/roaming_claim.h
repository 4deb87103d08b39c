#pragma once

#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::proxy::admission {

/// One device wherever it is: within a roaming domain an address means one device.
struct Identity {
  std::string domain, address;
  friend auto operator<=>(const Identity&, const Identity&) = default;
};

/// The value of a tuple `ROAMING.<domain>.<address as key part>`: its owner lists the device (docs/roaming.md).
struct Claim {
  OwnerId island{};     ///< owner of the tuple; not in its text
  std::string key;      ///< of the device's tuples there: `proxy.wsn-1.7`
  std::string network;  ///< key parts of network and device there
  std::string device;
  std::string address;
  WallTime since{};        ///< when it last joined there; zero = not since the island started
  bool reachable = false;  ///< from that island

  friend bool operator==(const Claim&, const Claim&) = default;
};

/// The newest join, then the lower island id, then the lower network: every island comes to the same result.
bool better(const Claim& one, const Claim& other);

/// {key, network, device, address, since, reachable}; since in seconds, exact to the microsecond.
std::string claim_text(const Claim& claim);
/// Parses the claim of another island. kInvalid: a member is missing or wrong, or `since` is after the year 2200.
Result<Claim> parse_claim(OwnerId island, std::string_view text);

/// `ROAMING.<domain>.<address as key part>`
std::string claim_key(const Identity& identity);
/// Whether it is that key, or a twin of it: `ROAMING.lab.1_7-2`.
bool is_claim_key(std::string_view key, const Identity& identity);

}  // namespace rubicon::proxy::admission
