#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/interfaces.h"
#include "transport/transports.h"
#include "tuples/peis/deliveries.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/own_messages.h"
#include "tuples/peis/troubles.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

struct NodeOptions {
  OwnerId id{};                     ///< 1..2^31-1
  std::uint32_t magic = 0;          ///< this start, 1..2^31-1; differs from that of every former start
  std::string network = "default";  ///< at most 63 bytes; nodes of other networks are not seen
  std::string host_name;            ///< without its domain, at most 63 bytes; G6 uses loopback only between equal ones
  std::string full_name;            ///< `name@host!pid`, at most 63 bytes
  Hello hello;                      ///< sent to every host that becomes routable
  std::uint16_t first_port = 8000;  ///< the first free port from here on is taken; 0 = any
  bool multicast = true;            ///< announce and listen on 227.1.3.5:10001
  /// Interfaces with an IPv4 address for announcements, and the addresses that others connect to; at most 16. With
  /// loopback interfaces only, no other host can connect.
  std::vector<transport::Interface> interfaces;
  std::vector<std::string> connect;  ///< `host:port` of nodes to stay connected with, at most 64
};

/// Called from the loop, never inside a call to the node. None may destroy the node.
struct NodeCallbacks {
  /// A message of a host between its kUp and its kLeft or kLost; the bytes are valid during the call. The ports are
  /// those of tuples (5, 6, 7, 10, 15, 16) and of ours (41 to 49): the node answers all others itself.
  std::function<void(OwnerId from, Port port, ByteView body)> message;
  std::function<void(HostEvent event, const Identity& host)> host;
  /// There is room again for messages to a host for which send() gave kBusy.
  std::function<void(OwnerId to)> ready;
  /// Another live node uses this node's id. Called once per magic of the other.
  std::function<void(const Identity& other)> id_taken;
};

/// A connection, for `kernel.connections` and diagnosis.
struct LinkState {
  OwnerId peer{};
  transport::Endpoint remote;
  std::uint64_t bytes_in = 0, bytes_out = 0;
  std::size_t unacknowledged = 0;  ///< bytes in the sockets
  bool ours = false;               ///< the peer sent a hello
};

/// A line of `kernel.routingTable`.
struct RouteState {
  OwnerId to{}, via{};
  int metric = 0;
};

/// A node of a PEIS network (G6, protocol 500) with at most 256 connections, and 32 more that it establishes:
/// discovery, connections, routing, acknowledged messages. Bodies pass unread. Destroying it says goodbye (DEAD_HOST)
/// and closes all.
class Node {
 public:
  /// kInvalid for options out of range, kBusy if none of 100 ports is free, else kIo. The scheduler, the transports and
  /// the sink of the log must outlive it. The calls begin in a later turn.
  static Result<std::unique_ptr<Node>> open(NodeOptions options, Scheduler& scheduler,
                                            transport::Transports& transports, Log log, NodeCallbacks calls);
  ~Node();

  /// Sends a message to a host that is up, in fragments if it is long; `done` may be empty, and is called once, in a
  /// later turn, unless this fails. Messages to one host arrive in the order of sending, except that those of a lost
  /// package arrive later (G6 has no order; between nodes of ours packages are lost only with a link on the way).
  /// kNotFound: no such host is up; kBusy: too much waits for it, ready() follows; kOutOfRange: longer than 16 MiB or a
  /// port above 49, which kills kernels.
  Result<void> send(OwnerId to, Port port, ByteView body, Done done = {});
  /// Sends a message to all hosts, once and without acknowledgement. kOutOfRange: longer than 1024 bytes or a port
  /// above 49.
  Result<void> broadcast(Port port, ByteView body);

  /// NodeOptions::full_name of what this node sends from now on.
  void rename(std::string full_name);

  /// The hosts that are up, by id.
  std::vector<Identity> hosts() const;
  /// Null: not up. Valid until the next turn.
  const Identity* host(OwnerId id) const;
  /// Whether a connection of the host comes from an address of this machine.
  bool is_here(OwnerId id) const;
  /// Messages to the host that wait or are not acknowledged, in packages; 0 = none.
  std::size_t unacknowledged(OwnerId to) const;

  transport::Endpoint local() const;  ///< where it listens
  std::vector<LinkState> links() const;
  std::vector<RouteState> routes() const;
  const NodeCounters& counters() const;
  const std::vector<Trouble>& troubles() const;

 private:
  struct Impl;
  explicit Node(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples::peis
