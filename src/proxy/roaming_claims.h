#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "proxy/proxy_context.h"
#include "proxy/roaming_claim.h"

namespace rubicon::proxy {

/// The claims of this island and of all others in the roaming domains it has. Knows who is there; decides nothing.
class RoamingClaims {
 public:
  struct Calls {
    /// Another island lists the device, says something new of it, or is back and still lists it.
    std::function<void(const Identity&)> claimed;
    /// Another island does not list it any more.
    std::function<void(const Identity&)> ceased;
  };
  RoamingClaims(ProxyContext& context, Calls calls);

  /// The domains from now on. Claims of others in a domain that went are forgotten; own ones must be withdrawn before.
  void follow(const std::set<std::string>& domains);

  /// Whether an island that claims a device is there.
  enum class Presence : std::uint8_t {
    kHere,
    kBack,  ///< since a moment; what it said before it was lost may be old
    kLost,  ///< crashed or cut off a short while ago
    kGone,  ///< left, or lost for longer than the grace period
  };
  struct Other {
    Claim claim;
    std::string tuple;        ///< its key
    SteadyTime renewed_at{};  ///< when its `since` last changed, on our clock; min = before we listened
    bool fresh = false;       ///< said since the island is there
  };
  void each(const Identity& identity, const std::function<void(const Other&, Presence)>& visit) const;
  /// The newest join that any other island knows of, present or not; zero = none.
  WallTime newest(const Identity& identity) const;
  /// The island lists the device, or was the last one that did.
  bool knows(const Identity& identity, OwnerId island) const;

  /// The key of the claim's tuple.
  std::string publish(const Identity& identity, const Claim& own);
  void withdraw(const Identity& identity);
  /// Which device one of our own claims stands for; nullptr = none.
  const Identity* meant_by(const std::string& tuple) const;

 private:
  struct Entry {
    std::map<OwnerId, Other> others;
    OwnerId former{};         ///< the last island that ceased to list it
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
  using Place = std::pair<OwnerId, std::string>;

  void take(const std::string& domain, const tuples::Event& event);
  void place(const Identity& identity, const std::string& tuple, Claim claim);
  void drop(const Place& place);
  void peer(OwnerId island, tuples::PeerEvent event);
  void each_of(OwnerId island, const std::function<void(const Identity&, Other&)>& visit);
  Presence presence(const Other& other) const;
  bool listened(OwnerId island, const std::string& domain) const;
  std::string free_tuple(const Identity& identity) const;
  void tidy(const Identity& identity);
  void check_clock(const Claim& claim);

  ProxyContext& context_;
  Calls calls_;
  std::map<std::string, Domain> domains_;
  std::map<Identity, Entry> entries_;
  std::map<Place, Identity> theirs_;
  std::map<std::string, Identity> own_;
  std::map<OwnerId, Peer> peers_;
  tuples::Handle peers_watch_;
};

/// Joins that two proxies hear within this time are one join; also how long an island that is back has to say what it
/// lists now.
inline constexpr Duration kRoamingSettles = std::chrono::milliseconds(300);

}  // namespace rubicon::proxy
