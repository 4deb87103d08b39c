#pragma once

#include <sys/types.h>

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::transport {

/// Called from the loop, never inside a call to the stream. Each may destroy the stream.
struct StreamCallbacks {
  /// The line or connection is established. Not called for an accepted connection.
  std::function<void()> connected;
  /// The next bytes of the stream, in pieces of any size; valid during the call.
  std::function<void(ByteView bytes)> received;
  /// The connection failed or ended, for any reason, such as an orderly close by the other end or an unplugged device.
  /// Called once.
  std::function<void(Error)> failed;
};

/// A TCP connection or a serial line; destroying it closes it.
class ByteStream {
 public:
  /// Maximum number of bytes that wait for a busy line, or for the connection.
  static constexpr std::size_t kMaxQueued = std::size_t{64} * 1024;

  virtual ~ByteStream() = default;
  /// Sends the bytes, or queues them while the line is busy or not connected yet: all or nothing. kBusy beyond
  /// kMaxQueued, kUnreachable after the connection was lost.
  virtual Result<void> send(ByteView bytes) = 0;
  /// While held, nothing is received: when the system's buffers are full, the other end cannot send. A lost connection
  /// may be noticed only afterwards.
  virtual void hold(bool held) = 0;
  /// Bytes of send() that the system has not accepted yet.
  virtual std::size_t queued() const = 0;
};

/// A serial line: 8 data bits, 1 stop bit, no parity, no flow control. Modem lines are not used, so that a
/// pseudo-terminal works too.
struct SerialOptions {
  std::string path;        ///< `/dev/ttyUSB0`, `/dev/serial/by-id/...`
  unsigned baud = 115200;  ///< a rate of termios: 50 to 4000000
};

/// Whether termios has the rate.
bool is_baud_rate(unsigned baud);

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
struct UdpCallbacks {
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

struct TcpOptions {
  /// Numeric address and port to connect to; names are looked up before (Transports::look_up).
  Endpoint remote;
  /// The attempt to connect fails after this time.
  Duration connect_timeout = std::chrono::seconds(10);
  /// The connection ends if sent bytes are not acknowledged for this long (RFC 5482); 0 = the system's default, which
  /// is minutes.
  Duration user_timeout = std::chrono::seconds(30);
  /// Interval between probes of a silent connection, in whole seconds; without answers it ends after the user timeout.
  /// 0 = no probes.
  Duration keep_alive = std::chrono::seconds(10);
};

using TcpCallbacks = StreamCallbacks;

/// A connection that is being established, or established. Destroying it closes it: bytes that the system accepted are
/// still sent, queued bytes are not. Small sends are transmitted at once (TCP_NODELAY).
class TcpStream : public ByteStream {
 public:
  virtual bool connected() const = 0;
  /// Bytes of send() that the other end's system has not acknowledged, with those of queued(); 0 after the connection
  /// was lost. It acknowledges what its buffers take, which its program may not have read.
  virtual std::size_t unacknowledged() const = 0;
  /// Aborts the connection: nothing more is sent, not even what the system accepted (RFC 9293, section 3.10.5). No
  /// calls follow; destroy the stream next.
  virtual void abort() = 0;
  /// Own address and port; empty until connected.
  virtual Endpoint local() const = 0;
  /// The other end's address and port; empty until connected.
  virtual Endpoint remote() const = 0;
};

/// Receives our end of an accepted connection, and returns its callbacks.
using TcpAccept = std::function<TcpCallbacks(std::unique_ptr<TcpStream> stream)>;

/// The listener cannot accept connections any longer, for good; it should be destroyed.
using ListenerFailed = std::function<void(Error)>;

/// Listens on a port until destroyed; accepted connections stay open.
class TcpListener {
 public:
  virtual ~TcpListener() = default;
  /// The bound address and port.
  virtual Endpoint local() const = 0;
};

/// Longest path of a socket, in bytes (unix(7): sun_path with its end).
inline constexpr std::size_t kMaxSocketPath = 107;

/// The process at the other end of a local stream when the connection began, as the kernel says: unix(7), SO_PEERCRED
/// and SO_PEERGROUPS. A user or a process that has no number here (another user or process namespace) is the overflow
/// uid, 65534, or process 0.
struct LocalPeer {
  uid_t user = 65534;
  pid_t process = 0;
  std::vector<gid_t> groups{};  ///< the first is its own group
};

/// Called from the loop, never inside a call to the stream. Each may destroy the stream.
struct LocalCallbacks {
  /// The next bytes, at most kMaxRead in one turn of the loop; valid during the call.
  std::function<void(ByteView bytes)> received;
  /// The system takes bytes again, after write() took less than it was given.
  std::function<void()> writable;
  /// The connection ended, for any reason. Called once, after all that the other end wrote was received.
  std::function<void(Error why)> failed;
};

/// A connection between two processes of one host; destroying it closes it. The bytes that write() took still arrive.
class LocalStream {
 public:
  static constexpr std::size_t kMaxRead = std::size_t{256} * 1024;

  virtual ~LocalStream() = default;
  /// Returns how many of the first bytes the system took. After less than all, `writable` is called once. kUnreachable:
  /// the other end is gone; `failed` follows.
  virtual Result<std::size_t> write(ByteView bytes) = 0;
  /// What write() took and the other process has not read, in bytes as the system counts them: less only when it reads.
  virtual std::size_t unread() const = 0;
  virtual const LocalPeer& peer() const = 0;
};

/// Receives our end of an accepted connection, and returns its calls.
using LocalAccept = std::function<LocalCallbacks(std::unique_ptr<LocalStream> stream)>;

/// Accepts connections until destroyed; those that were accepted stay open.
class LocalListener {
 public:
  virtual ~LocalListener() = default;
};

}  // namespace rubicon::transport
