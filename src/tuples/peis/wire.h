#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::tuples::peis {

// What kernels of G6 (version 0.6.0.7, protocol 500) say to each other below the tuples: peis.md, section 3, as
// corrected in section 6. read_x() takes the whole body; its errors name the field with its offset and what was
// expected. write() clears all padding. Readers never look at padding: kernels send old memory there.

inline constexpr std::uint32_t kProtocolVersion = 500;
inline constexpr std::string_view kMulticastGroup = "227.1.3.5";  ///< section 3.2
inline constexpr std::uint16_t kMulticastPort = 10001;
inline constexpr int kMulticastHops = 3;
inline constexpr std::uint16_t kFirstListenPort = 8000;  ///< and the next free ones; section 3.3
inline constexpr std::size_t kMaxNameLength = 63;        ///< bytes; of networks, hosts, components
inline constexpr std::uint32_t kAnyId = 0xffffffff;
inline constexpr std::uint32_t kMaxId = 0x7fffffff;  ///< of components, packages, acks; negative ids close a connection

inline constexpr OwnerId kEveryone{kAnyId};  ///< destination of link and broadcast packages

// Timers (peis.md, sections 3.3, 3.6, 3.7, 3.10, 6.1).
inline constexpr auto kAnnouncePeriod = std::chrono::seconds(1);
inline constexpr auto kAnnounceSilence = std::chrono::seconds(3);    ///< before the first announcement
inline constexpr auto kClusterPeriod = std::chrono::seconds(2);      ///< one try to connect to another cluster
inline constexpr auto kRoutingPeriod = std::chrono::seconds(10);     ///< also one step of ageing
inline constexpr auto kTimePeriod = std::chrono::seconds(10);        ///< TIMESYNC
inline constexpr auto kAckDelay = std::chrono::milliseconds(200);    ///< at most, before acks are sent
inline constexpr auto kResendStep = std::chrono::milliseconds(400);  ///< resend n follows n steps after the one before
inline constexpr int kResends = 7;                                   ///< then the package is given up
inline constexpr auto kSilenceLimit = std::chrono::seconds(30);      ///< of a connection
inline constexpr auto kAssemblyTimeout = std::chrono::seconds(10);   ///< of a long message
inline constexpr auto kReconnectPeriod = std::chrono::seconds(30);   ///< of a configured peer
inline constexpr auto kConnectMessageWait = std::chrono::milliseconds(200);

// Limits (sections 3.4, 3.6, 3.7, 6.1, 6.2).
inline constexpr std::size_t kMaxUnacknowledgedBytes = 20000;  ///< in the socket towards a kernel
inline constexpr std::size_t kDuplicateTable = 4096;           ///< package and ack ids that a receiver remembers
inline constexpr std::uint8_t kMaxHops = 14;                   ///< a package with this number of hops is dropped
inline constexpr std::uint8_t kUnreachableMetric = 10;
inline constexpr std::uint8_t kLostRoute = 250;     ///< hops of a route that was lost; + 1 in each step of ageing
inline constexpr std::uint8_t kDeletedRoute = 254;  ///< hops at which it is forgotten

/// Where an address of a host leads. Others may come; only TCP over IPv4 is used.
enum class AddressType : std::uint32_t { kTcp4 = 0, kUdp4 = 1, kTcp6 = 2, kBluetooth = 3 };

/// One of the addresses that a host listens at, 24 bytes.
struct HostAddress {
  std::string device;  ///< interface, `lo`; at most 8 bytes
  bool loopback = false;
  AddressType type = AddressType::kTcp4;
  std::array<std::uint8_t, 4> ip{};
  std::uint32_t port = 0;  ///< as sent: check the range
  friend bool operator==(const HostAddress&, const HostAddress&) = default;
};

/// Who a component is and where it listens, 544 bytes. The time at 528 means nothing to others: written as zero.
struct HostRecord {
  OwnerId id{};
  std::uint32_t magic = 0;             ///< random at each start: tells incarnations apart
  std::string host_name;               ///< texts longer than kMaxNameLength are cut when written
  std::string full_name;               ///< `name@host!pid`
  std::vector<HostAddress> addresses;  ///< at most kMaxAddresses
  OwnerId cluster{};                   ///< the lowest id that it can reach
  std::uint32_t flags = 0;
  friend bool operator==(const HostRecord&, const HostRecord&) = default;
};
inline constexpr std::size_t kMaxAddresses = 16;
inline constexpr std::size_t kHostRecordSize = 544;

/// The datagram of the announcer of a host, 616 bytes (section 3.2).
struct Announcement {
  std::string network;  ///< 1 to kMaxNameLength bytes
  HostRecord host;
  friend bool operator==(const Announcement&, const Announcement&) = default;
};
inline constexpr std::size_t kAnnouncementSize = 616;
/// kUnsupported: another protocol version; the text names the version and who has it.
Result<Announcement> read_announcement(ByteView datagram);
Bytes write(const Announcement& announcement);

/// The first 76 bytes of a connection, from the side that opened it (section 3.3).
struct ConnectMessage {
  OwnerId id{};
  std::uint32_t flags = 0;
  std::string network;  ///< 1 to kMaxNameLength bytes
  friend bool operator==(const ConnectMessage&, const ConnectMessage&) = default;
};
inline constexpr std::size_t kConnectSize = 76;
// Why the initiator connects.
inline constexpr std::uint32_t kForceBroadcasts = 1, kForcedByBandwidth = 2, kForcedByCluster = 4;
/// kUnsupported: another protocol version.
Result<ConnectMessage> read_connect(ByteView bytes);
Bytes write(const ConnectMessage& message);

/// What a package carries (section 3.5). Ports up to kLastPort may come that are not named here; kernels ignore them.
enum class Port : std::uint16_t {
  kRouting = 0,
  kTrace = 1,
  kTraceReply = 2,
  kSubscribe = 5,
  kUnsubscribe = 6,
  kPush = 7,
  kDeadHost = 9,
  kSetRemote = 10,
  kTimeSync = 11,
  kQueryHost = 12,
  kHostInfo = 13,
  kAcks = 14,
  kSetAppend = 15,
  kPushAppended = 16,
  // Between components of ours: kernels acknowledge and ignore these (section 6.1, 6).
  kHello = 40,
  kReply = 41,
  kSummary = 42,
  kSnapshot = 43,
};
/// A package with a higher port kills a kernel: never sent, never forwarded (section 6.1, 6).
inline constexpr std::uint16_t kLastPort = 49;
/// `PUSH_TUPLE`; `port 17` for ports without a name.
std::string to_string(Port port);

/// Who receives a package: the other end of the connection, everybody, its destination. Others may come: drop those.
enum class Routing : std::uint8_t { kLink = 0, kBroadcast = 1, kDirect = 2 };

/// The 40 bytes in front of each body (section 3.4).
struct PackageHeader {
  std::uint32_t id = 0;       ///< 1 to kMaxId, random, new at each resend; kernels take 0 too
  std::uint32_t counter = 0;  ///< of the packages of this connection, from 0
  std::uint32_t ack_id = 0;   ///< constant over resends; equal to `id` if no ack is wanted
  std::uint16_t flags = 0;
  Routing routing = Routing::kLink;
  std::uint8_t hops = 1;
  OwnerId source{};
  OwnerId destination = kEveryone;
  Port port = Port::kRouting;
  std::uint16_t length = 0;     ///< of the body, 0 to kMaxBody
  std::uint16_t fragments = 0;  ///< of the long message that this is a part of; 0 = this is a whole message
  std::uint16_t message = 0;    ///< id of the long message
  std::uint16_t fragment = 0;   ///< index, from 0

  bool wants_ack() const { return (flags & 1) != 0; }
  friend bool operator==(const PackageHeader&, const PackageHeader&) = default;
};
inline constexpr std::size_t kHeaderSize = 40;
inline constexpr std::size_t kMaxBody = 1024;
inline constexpr std::uint16_t kFlagWantsAck = 1, kFlagBulk = 4, kFlagHighPriority = 8;

/// Reads the first kHeaderSize of the given bytes, which may be more. kInvalid closes the connection: bad sync, length
/// above kMaxBody, a negative package, ack, source or destination id (but kEveryone).
Result<PackageHeader> read_package_header(ByteView bytes);
/// Appends header and body; the length is that of the body, at most kMaxBody.
void append_package(Bytes& out, const PackageHeader& header, ByteView body);
/// Writes the fields that change between sends into a package of append_package().
void restamp_package(std::span<std::uint8_t> package, std::uint32_t id, std::uint32_t counter);

/// One known route (section 3.7).
struct RouteEntry {
  OwnerId id{};
  std::uint32_t sequence = 0;  ///< of the host's own ROUTING
  std::uint32_t magic = 0;     ///< of the host
  std::uint8_t hops = 0;
  std::uint8_t connections = 0;
  friend bool operator==(const RouteEntry&, const RouteEntry&) = default;
};

/// ROUTING: one page of the routing table of the sender.
struct RoutingPage {
  std::uint16_t page = 0, pages = 1;
  std::uint32_t sequence = 0;       ///< of the sender
  std::vector<RouteEntry> entries;  ///< at most kMaxRoutesOfPage
  friend bool operator==(const RoutingPage&, const RoutingPage&) = default;
};
inline constexpr std::size_t kMaxRoutesOfPage = 70;
Result<RoutingPage> read_routing_page(ByteView body);
Bytes write(const RoutingPage& page);

/// ACKS (section 3.6).
struct Acks {
  std::vector<std::uint32_t> ids;  ///< at most kMaxAcks when written, kMaxReadAcks when read
  friend bool operator==(const Acks&, const Acks&) = default;
};
inline constexpr std::size_t kMaxAcks = 100, kMaxReadAcks = (kMaxBody - 4) / 4;
Result<Acks> read_acks(ByteView body);
Bytes write(const Acks& acks);

/// QUERY_HOST, sent to a host whose HOSTINFO is wanted. Kernels answer only if the magic is kAnyId (section 6.4, 30).
struct QueryHost {
  OwnerId asker{};
  std::uint32_t magic = kAnyId;
  friend bool operator==(const QueryHost&, const QueryHost&) = default;
};
Result<QueryHost> read_query_host(ByteView body);
Bytes write(const QueryHost& query);

/// HOSTINFO.
struct HostRecordMessage {
  HostRecord host;
  bool cached = false;  ///< from a host on the way that knows the one that was asked
  friend bool operator==(const HostRecordMessage&, const HostRecordMessage&) = default;
};
Result<HostRecordMessage> read_host_info(ByteView body);
Bytes write(const HostRecordMessage& message);

/// Why a host is dead. Kernels act only on kLost (section 6.1, 3). Others may come.
enum class DeathReason : std::uint32_t { kMessage = 0, kLost = 1, kReborn = 2 };

/// DEAD_HOST.
struct DeadHost {
  OwnerId id{};
  DeathReason reason = DeathReason::kLost;
  friend bool operator==(const DeadHost&, const DeadHost&) = default;
};
Result<DeadHost> read_dead_host(ByteView body);
Bytes write(const DeadHost& dead);

/// TIMESYNC (section 3.9).
struct TimeSync {
  std::uint32_t seconds = 0;       ///< since 1970
  std::uint32_t microseconds = 0;  ///< 0 to 999999
  bool master = false;
  friend bool operator==(const TimeSync&, const TimeSync&) = default;
};
Result<TimeSync> read_time_sync(ByteView body);
Bytes write(const TimeSync& time);

/// TRACE and TRACE_REPLY: each node on the way adds its id (section 6.4, 31).
struct Trace {
  std::vector<OwnerId> path;  ///< at most kMaxTrace
  friend bool operator==(const Trace&, const Trace&) = default;
};
inline constexpr std::size_t kMaxTrace = 15;
Result<Trace> read_trace(ByteView body);
Bytes write(const Trace& trace);

}  // namespace rubicon::tuples::peis
