#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"

namespace rubicon::tuples::peis {

/// What a node counted since its start; each counter is about something that was not done.
struct NodeCounters {
  std::uint64_t bad_streams = 0;       ///< connections closed for bytes that are no packages
  std::uint64_t foreign_versions = 0;  ///< connections and announcements of another protocol version
  std::uint64_t foreign_networks = 0;  ///< connections and announcements of another network
  std::uint64_t bad_announcements = 0;
  std::uint64_t bad_bodies = 0;       ///< node-level packages that could not be decoded
  std::uint64_t high_ports = 0;       ///< packages with a port above 49
  std::uint64_t bad_ids = 0;          ///< packages with a source or destination of 0 or below
  std::uint64_t hop_limit = 0;        ///< packages that reached 14 hops
  std::uint64_t loops = 0;            ///< packages that would go back where they came from
  std::uint64_t duplicates = 0;       ///< packages received before
  std::uint64_t unknown_sources = 0;  ///< messages of hosts that were not up
  std::uint64_t held_requests = 0;    ///< not kept until the place of their kernel is known: too many
  std::uint64_t no_route = 0;         ///< packages to forward to a host without a route
  std::uint64_t queue_full = 0;       ///< packages to forward that found the link busy
  std::uint64_t forged_deaths = 0;    ///< DEAD_HOST by others than the host
  std::uint64_t held_deaths = 0;      ///< DEAD_HOST about this node within 10 s of the last one of the host
  std::uint64_t forged_hellos = 0;    ///< hellos by others than the host, or that differ from its first one
  std::uint64_t other_starts = 0;     ///< infos of another start of a host that is up, not on its own connection
  std::uint64_t time_messages = 0;    ///< TIMESYNC, which kernels send as a rule; always ignored
  std::uint64_t too_many_hosts = 0;
  std::uint64_t too_many_routes = 0;
  std::uint64_t too_many_links = 0;   ///< connections refused
  std::uint64_t held_broadcasts = 0;  ///< that were not passed on, as one connection brought too many
  std::uint64_t untried_hosts = 0;    ///< that no connection was tried to, as too many wait for one
  std::uint64_t fragments_dropped = 0;
  std::uint64_t stuck_links = 0;  ///< connections without progress for 2 s
  std::uint64_t silent_links = 0;
  std::uint64_t resends = 0;
  std::uint64_t given_up = 0;     ///< messages
  std::uint64_t own_id_seen = 0;  ///< connections and infos of another node with this node's id
};

enum class TroubleKind : std::uint8_t {
  kForeignNetwork,  ///< it belongs to another network
  kForeignVersion,  ///< it speaks another version of the protocol
  kUnreachable,     ///< it is known or configured, but the last attempt to connect failed
  kOwnId,           ///< it uses the id of this node
  kSharedId,        ///< a start of this id that ended is still there: two programs use the id
};

/// A program with which a node cannot exchange messages, or that it cannot identify.
struct Trouble {
  TroubleKind kind{};
  OwnerId id{};        ///< 0 = not known
  std::string name;    ///< `tupleview@desk!4711`, or its address; may be empty
  std::string detail;  ///< its network, an error, ...
  std::uint64_t times = 0;

  friend bool operator==(const Trouble&, const Trouble&) = default;
};

/// The last troubles of a node, for diagnosis: one for each kind, id and name, at most kMax.
class Troubles {
 public:
  static constexpr std::size_t kMax = 128;

  void note(TroubleKind kind, OwnerId id, std::string_view name, std::string_view detail);
  /// The program with this id, or by this address, was reached.
  void reached(OwnerId id, std::string_view address);
  const std::vector<Trouble>& all() const { return all_; }

 private:
  std::vector<Trouble> all_;  ///< the one that was noted last is the last
};

}  // namespace rubicon::tuples::peis
