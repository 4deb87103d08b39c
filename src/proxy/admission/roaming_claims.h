#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "proxy/device_directory.h"
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

/// The roaming claims of this island and of all others, in the domains of its networks, and which islands are up.
/// Decides nothing.
class RoamingClaims {
 public:
  struct Callbacks {
    /// Another island published a claim, changed it, or is up again and still holds it.
    std::function<void(const Identity&)> claimed;
    /// Another island withdrew its claim.
    std::function<void(const Identity&)> unclaimed;
  };
  RoamingClaims(ProxyContext& context, Callbacks callbacks);

  /// Follows exactly these domains. Claims of others in other domains are forgotten; withdraw own ones there before.
  void follow(const std::set<std::string>& domains);

  /// Whether the island of a claim is up.
  enum class Presence : std::uint8_t {
    kHere,
    kBack,  ///< came up a moment ago: its claim from before may be outdated
    kLost,  ///< down without leaving, for less than the grace period
    kGone,  ///< left, or down for longer
  };
  struct Other {
    Claim claim;
    std::string tuple;        ///< its key
    SteadyTime renewed_at{};  ///< when its `since` last changed, on our clock; min = before we subscribed
    bool fresh = false;       ///< published since the island came up
  };
  void each(const Identity& identity, const std::function<void(const Other&, Presence)>& visit) const;
  /// The newest join that any other island knows of, up or not; zero = none.
  WallTime newest(const Identity& identity) const;
  /// The island claims the device, or was the last that withdrew its claim.
  bool has_claimed(const Identity& identity, OwnerId island) const;

  /// Another island takes a device over by this claim, or may not: a line of the audit.
  void record(OwnerId island, std::string_view tuple, const Result<void>& answer) const;

  /// Sets our claim. Returns the key of its tuple.
  std::string publish(const Identity& identity, const Claim& own);
  void withdraw(const Identity& identity);
  /// The device of an own claim, by the key of its tuple; nullptr = no own claim.
  const Identity* identity_of_own(const std::string& tuple) const;

 private:
  struct Entry {
    std::map<OwnerId, Other> others;
    OwnerId former{};         ///< the last island that withdrew its claim
    std::string tuple, text;  ///< of our own claim; empty = none
  };
  struct Domain {
    SteadyTime since{};
    tuples::Handle subscription;
  };
  struct Peer {
    bool up = true;
    bool left = false;
    SteadyTime since{};
    Timer settled;
  };
  using OtherKey = std::pair<OwnerId, std::string>;  ///< owner and key of a claim

  void take(const std::string& domain, const tuples::Event& event);
  void store(const Identity& identity, const std::string& tuple, Claim claim);
  void drop(const OtherKey& claim);
  void peer(OwnerId island, tuples::PeerEvent event);
  void each_of(OwnerId island, const std::function<void(const Identity&, Other&)>& visit);
  Presence presence(const Other& other) const;
  bool is_recent(OwnerId island, const std::string& domain) const;
  std::string free_tuple(const Identity& identity) const;
  void tidy(const Identity& identity);
  Result<Claim> read_claim(const std::string& domain, const tuples::TupleView& tuple) const;
  Result<void> may_claim(const Identity& identity, const tuples::TupleView& tuple) const;
  void check_clock(const Claim& claim);

  ProxyContext& context_;
  Callbacks callbacks_;
  std::map<std::string, Domain> domains_;
  std::map<Identity, Entry> entries_;
  std::map<OtherKey, Identity> theirs_;
  std::map<std::string, Identity> own_;  ///< by the key of the claim
  std::map<OwnerId, Peer> peers_;
  tuples::Handle peers_watch_;
};

/// Joins that two proxies hear within this time are one join. An island that came up has the same time to publish its
/// claims again.
inline constexpr Duration kRoamingSettles = std::chrono::milliseconds(300);

}  // namespace rubicon::proxy::admission
