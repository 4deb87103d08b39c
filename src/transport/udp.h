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

/// A numeric address (`127.0.0.1`, `::1`) and a port. IPv4 is always spelled as IPv4, whatever socket it came through.
struct Endpoint {
  std::string address;
  std::uint16_t port = 0;

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
  friend auto operator<=>(const Endpoint&, const Endpoint&) = default;
};

/// `127.0.0.1:9000`, `[::1]:9000`.
std::string to_string(const Endpoint& endpoint);

/// What a socket has to do with groups (IPv4; RFC 1112).
struct UdpMulticast {
  /// Heard besides what is sent to the bound address: 224.0.0.0 to 239.255.255.255.
  std::vector<std::string> groups{};
  /// IPv4 address of the interface that groups are joined on and datagrams to groups leave by; empty = the system's
  /// choice.
  std::string interface_address{};
  std::uint8_t ttl = 1;  ///< of datagrams to groups: how many routers they may pass
  bool loopback = true;  ///< datagrams to groups reach those on this machine too, the sender among them
};

struct UdpOptions {
  /// Numeric address and port to bind. An empty address takes datagrams on all of the machine's; port 0 = any free one.
  Endpoint local;
  /// Longest datagram that is received whole, in bytes (1..65536); a longer one arrives cut to this size.
  std::size_t largest = 2048;
  /// The only one who is heard and may be sent to (connect()); nullopt = everybody.
  std::optional<Endpoint> remote{};
  /// Makes it an IPv4 socket. To hear a group on a port that others on this machine use too, bind the group's address:
  /// who binds the machine's takes what is sent to the machine from the others.
  std::optional<UdpMulticast> multicast{};
  /// Others who ask for it too may bind the same port (SO_REUSEADDR).
  bool reuse_address = false;
};

/// Called from the loop, never from inside a call to the socket. The socket may be destroyed in any of them.
struct UdpCalls {
  /// The bytes are only good during the call.
  std::function<void(const Endpoint& from, ByteView bytes)> received;
  /// A datagram could not be delivered (nobody listens there, no route); the socket goes on.
  std::function<void(Error)> undelivered;
  /// The socket receives nothing any more.
  std::function<void(Error)> failed;
};

/// Sends and receives datagrams. Destroyed = closed, at once; what was sent before goes out if the system took it.
class UdpSocket {
 public:
  /// Datagrams that wait for a busy line; more are refused.
  static constexpr std::size_t kMaxQueued = 64;

  virtual ~UdpSocket() = default;
  /// Hands the datagram over, or queues it while the line is busy. kBusy beyond kMaxQueued, and when a queue of the
  /// system is full (counted as dropped),
  /// kInvalid if `to` is not numeric, kOutOfRange if it is too long for a datagram, else kIo.
  virtual Result<void> send(const Endpoint& to, ByteView bytes) = 0;
  /// Leaves its groups and joins them again, so that the system tells switches and routers of it (RFC 3376); what has
  /// come by then is still heard. kIo names the group that cannot be joined any more.
  virtual Result<void> rejoin() = 0;
  /// What was bound, with the port the system chose.
  virtual Endpoint local() const = 0;
  /// Datagrams that send() refused or the system dropped after they were queued.
  virtual std::uint64_t dropped() const = 0;
};

/// A name being looked up.
class Lookup {
 public:
  virtual ~Lookup() = default;
};

using LookupDone = std::function<void(Result<std::vector<std::string>>)>;

}  // namespace rubicon::transport
