#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "base/deadline.h"
#include "base/lifetime.h"
#include "base/limited_log.h"
#include "base/paced_call.h"
#include "tuples/peis/announcer.h"
#include "tuples/peis/connection.h"
#include "tuples/peis/deliveries.h"
#include "tuples/peis/dialer.h"
#include "tuples/peis/fragments.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/id_check.h"
#include "tuples/peis/node.h"
#include "tuples/peis/routes.h"
#include "tuples/peis/seen_ids.h"
#include "tuples/peis/troubles.h"

namespace rubicon::tuples::peis {

/// How often something may happen in a time.
struct Budget {
  SteadyTime since{};
  int taken = 0;

  /// Whether it is one of the first `most` of the period.
  bool take(SteadyTime now, int most, Duration period) {
    if (now - since >= period) since = now, taken = 0;
    return ++taken <= most;
  }
};

/// A connection and what it is for.
struct NodeLink {
  LinkId id{};
  std::unique_ptr<Connection> connection;
  bool initiated = false;  ///< by this node
  Target target;
  OwnerId peer{};                  ///< 0 = not known yet
  std::uint32_t magic = 0;         ///< of the peer; 0 = its host record has not come, and the link is no route
  bool ours = false;               ///< the peer sent a hello
  std::vector<RoutingPage> early;  ///< came before the host record
  Timer record_due;
  Budget broadcasts, changes;  ///< that are passed on; routing changes that are

  bool is_route() const { return magic != 0; }
};

inline bool is_id(OwnerId id) {
  return number(id) > 0 && number(id) <= kMaxId;
}

/// Wires the rooms of a node. Its parts: links (node_links.cpp), packages (node_packages.cpp), what hosts say of hosts
/// (node_claims.cpp), hosts (node_hosts.cpp) and where they run (node_places.cpp).
struct Node::Impl {
  static constexpr std::size_t kMaxLinks = 256;
  static constexpr std::size_t kReservedLinks = 32;  ///< besides, for those that this node establishes
  static constexpr std::size_t kMaxStrangers = 32;   ///< accepted connections that have not sent who they are
  static constexpr std::size_t kMaxUnmet = 64;       ///< those included, accepted ones without a host record
  static constexpr std::size_t kMaxUnmetOfHost = 8;  ///< from one address of another host
  static constexpr Duration kRecordTime = std::chrono::seconds(5);  ///< from the connect message to the host record
  static constexpr std::size_t kMaxEarlyPages = 16;
  static constexpr std::size_t kMaxTakenMagics = 16;
  static constexpr Duration kClaimTime = std::chrono::seconds(1);  ///< for the record of one with the id of this node
  static constexpr int kPortsToTry = 100;
  static constexpr int kMaxBroadcasts = 1000;  ///< of one connection that are passed on, in a second
  static constexpr int kMaxChanges = 40;       ///< routing pages of one connection that are passed on at once, in 10 s
  static constexpr Duration kUpdatePause = std::chrono::milliseconds(100);
  static constexpr std::size_t kMaxDoubts = 64;
  static constexpr Duration kProofTime = std::chrono::seconds(3);  ///< for what came another way than its host's own
  static constexpr Duration kPlaceTime = std::chrono::seconds(5);  ///< for a connection that shows where a kernel runs
  static constexpr Duration kForgetPlace =
      std::chrono::minutes(1);  ///< requests of one that did not show it wait again
  static constexpr std::size_t kMaxPlaceless = 64, kMaxHeld = 256, kMaxHeldOfOne = 32, kMaxHeldBytes = 1'000'000;
  static constexpr Duration kForgottenPause = std::chrono::seconds(10);  ///< sending all again costs much

  Impl(NodeOptions o, std::vector<base::HostPort> connect, Scheduler& s, transport::Transports& t, Log l, NodeCalls c);
  ~Impl();
  Result<void> open();
  Result<void> listen(std::uint16_t port);

  // Links.
  transport::TcpCalls accept(std::unique_ptr<transport::TcpStream> stream);
  bool dial(const Target& target, const transport::Endpoint& to, std::uint32_t flags);
  NodeLink& make_link(bool initiated);
  bool greeted(NodeLink& link, const ConnectMessage& message);
  void greet(NodeLink& link);
  void meet(NodeLink& link, const HostRecord& record);
  void drop_duplicates(OwnerId peer);
  void unreachable(const Target& target, const Error& error);
  std::string address_of(const Target& target) const;
  void close(NodeLink& link);
  void closed(LinkId id, Ending why, const Error& error);
  void remove(LinkId id, bool broken);
  void widen_links(OwnerId peer);
  bool is_linked(OwnerId peer) const;
  std::size_t strangers() const;
  bool may_accept(const std::string& address) const;
  bool has_room(std::size_t limit) const;
  void expect_record(NodeLink& link);
  NodeLink* link(LinkId id);

  // Routing.
  void apply(const RouteChanges& changes, std::optional<std::pair<OwnerId, SteadyTime>> heard = std::nullopt);
  void find_routable(const RouteChanges& changes);
  void take_routing(NodeLink& link, const RoutingPage& page);
  void periodic();
  void update();
  void send_routing(NodeLink& link);

  // Packages.
  void received(NodeLink& link, const Package& package);
  bool is_sound(const NodeLink& link, const PackageHeader& header);
  /// Counts it, with one line in the log a minute.
  void dropped(std::uint64_t& counter, const std::string& what, const NodeLink& from, const PackageHeader& header);
  void received_broadcast(NodeLink& link, const Package& package);
  void received_direct(NodeLink& link, const Package& package);
  void forward(NodeLink& from, const Package& package);
  bool take(NodeLink& link, const Package& package);
  bool take_node_message(NodeLink& link, const Package& package);
  void take_message(const Package& package);

  // What hosts say of hosts.
  bool speaks_for(const NodeLink& link, OwnerId source) const;
  bool is_forged(const NodeLink& link, const Package& package);
  bool is_forged_death(const NodeLink& link, const Package& package);
  void refuse(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what);
  /// Refuses it in kProofTime, unless it was true by then.
  void doubt(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what,
             std::function<bool()> is_true);
  void judge_doubts();
  void take_hello(NodeLink& link, const Package& package);
  void take_record(NodeLink& link, const PackageHeader& header, const HostRecordMessage& message);
  void take_newcomer(const NodeLink& link, const PackageHeader& header, const HostRecord& record);
  RecordSource source_of(const NodeLink& link, const PackageHeader& header, const HostRecordMessage& message) const;
  bool is_other_start(const HostRecord& record, std::string_view from);
  bool take_death(const PackageHeader& header, const DeadHost& dead);
  void forgotten_by(OwnerId host);

  // Where kernels run (node_places.cpp).
  bool is_here(OwnerId host) const;
  bool has_no_place(OwnerId kernel) const;
  void hold(const Package& package);
  void release();
  bool is_held(OwnerId kernel) const;

  // Answers.
  void answer_query(const QueryHost& query);
  void answer_trace(OwnerId asker, Trace trace);

  // Sending.
  PackageHeader header_for(Routing routing, Port port, OwnerId destination);
  void send_on(NodeLink& link, Routing routing, Port port, ByteView body);
  void send_direct(OwnerId to, Port port, ByteView body);
  void flood(ByteView package, std::optional<LinkId> except);
  Emitted emit(OwnerId to, std::span<std::uint8_t> package, bool urgent);

  // Hosts.
  HostRecord own_record() const;
  void announced(const HostRecord& record);
  void id_claimed(const HostRecord& record);
  void id_taken(const Identity& other);
  void own_id_in(const Package& package);
  void happened(HostEvent event, const Identity& host);
  void welcome(OwnerId host);
  void returned(const Identity& host);
  void leave_host(OwnerId host);

  NodeOptions options;
  Scheduler& scheduler;
  transport::Transports& transports;
  base::LimitedLog log;
  NodeCalls calls;
  Counters counters;
  Troubles troubles;
  Hosts hosts;
  Routes routes;
  Deliveries deliveries;
  Fragments fragments;
  Dialer dialer;
  IdCheck id_check;
  SeenIds broadcasts{kDuplicateTable};
  std::map<LinkId, NodeLink> links;
  std::uint64_t last_link = 0;
  std::vector<std::unique_ptr<Connection>> over;  ///< closed in this turn
  std::set<std::uint32_t> taken_magics;
  struct Forgetful {
    SteadyTime not_before{};
    Timer timer;
  };
  std::map<OwnerId, Forgetful> forgetful;  ///< hosts that forgot this node
  /// A message in the name of a neighbour that came by another one.
  struct Doubt {
    SteadyTime due{};
    std::function<bool()> is_true;
    std::function<void()> refuse;
  };
  std::deque<Doubt> doubts;
  struct Held {
    PackageHeader header;
    Bytes body;
  };
  std::vector<Held> held;                   ///< requests of `placeless`, in order
  std::map<OwnerId, SteadyTime> placeless;  ///< kernels that say they are here, and since when that is unknown
  base::Deadline place_due;
  Timer proofs;
  std::uint32_t sequence = 0;
  std::unique_ptr<transport::TcpListener> listener;
  transport::Endpoint local;  ///< where it listens
  std::unique_ptr<Announcer> announcer;
  base::PacedCall updates;
  base::OncePerTurn cleaning, pumping;
  Timer period;
  base::Lifetime lifetime;
};

}  // namespace rubicon::tuples::peis
