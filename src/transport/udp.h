#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::transport {

/// A numeric address (`127.0.0.1`, `::1`) and a port. IPv4 addresses are written as IPv4 even if they
/// came through an IPv6 socket.
struct Endpoint {
  std::string address;
  std::uint16_t port = 0;

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
  friend auto operator<=>(const Endpoint&, const Endpoint&) = default;
};

/// `127.0.0.1:9000`, `[::1]:9000`.
std::string to_string(const Endpoint& endpoint);

/// Multicast settings of a socket (IPv4; RFC 1112).
struct UdpMulticast {
  /// Groups to join, 224.0.0.0 to 239.255.255.255.
  std::vector<std::string> groups{};
  /// IPv4 address of the interface for joining groups and for sending to them; empty = the system's choice.
  std::string interface_address{};
  std::uint8_t ttl = 1;  ///< maximum number of hops of datagrams to groups
  bool loopback = true;  ///< datagrams to groups also reach members on this machine, including the sender
};

struct UdpOptions {
  /// Numeric address and port to bind. Empty address = all addresses of the machine; port 0 = any free one.
  Endpoint local;
  /// Longest datagram that is received whole, in bytes (1..65536); longer ones are cut to this size.
  std::size_t largest = 2048;
  /// The only endpoint to receive from and send to (connect()); nullopt = any.
  std::optional<Endpoint> remote{};
  /// Makes it an IPv4 socket. If other programs on this machine use the port too, bind the address of the group:
  /// binding the machine's address would take unicast datagrams away from them.
  std::optional<UdpMulticast> multicast{};
  /// Other sockets with this option may bind the same port (SO_REUSEADDR).
  bool reuse_address = false;
};

/// Called from the loop, never inside a call to the socket. Each may destroy the socket.
struct UdpCalls {
  /// The bytes are valid during the call.
  std::function<void(const Endpoint& from, ByteView bytes)> received;
  /// A datagram was not delivered (no listener, no route); the socket stays usable.
  std::function<void(Error)> undelivered;
  /// The socket cannot receive any longer.
  std::function<void(Error)> failed;
};

/// Sends and receives datagrams. Destroying it closes it; queued datagrams are dropped.
class UdpSocket {
 public:
  /// Maximum number of datagrams that wait for a busy line.
  static constexpr std::size_t kMaxQueued = 64;

  virtual ~UdpSocket() = default;
  /// Sends the datagram, or queues it while the line is busy. kBusy beyond kMaxQueued or if a queue of the system is
  /// full (counted as dropped), kInvalid if `to` is not numeric, kOutOfRange if the bytes do not fit into a datagram,
  /// else kIo.
  virtual Result<void> send(const Endpoint& to, ByteView bytes) = 0;
  /// Leaves the groups and joins them again, so that the system reports the membership to switches and routers
  /// (RFC 3376); datagrams that have arrived are kept. kIo names the group that cannot be joined again.
  virtual Result<void> rejoin() = 0;
  /// The bound address and port.
  virtual Endpoint local() const = 0;
  /// Number of datagrams that send() refused, or that the system dropped after they were queued.
  virtual std::uint64_t dropped() const = 0;
};

/// A pending lookup; destroying it cancels the call.
class Lookup {
 public:
  virtual ~Lookup() = default;
};

using LookupDone = std::function<void(Result<std::vector<std::string>>)>;

}  // namespace rubicon::transport
