#include "tuples/peis/wire.h"

#include "base/assert.h"
#include "rubicon/key.hpp"
#include "tuples/peis/fields.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::uint32_t kSync = 0xff00aa00;
constexpr std::size_t kNameField = kMaxNameLength + 1;
constexpr std::size_t kAddressSize = 24, kFirstAddress = 144;
constexpr std::size_t kDeviceField = 8;

Result<OwnerId> id_at(std::string_view body, std::string_view field, ByteView bytes, std::size_t at) {
  const auto id = u32_at(bytes, at);
  if (id <= kMaxId) return OwnerId{id};
  return wrong_field(body, fmt::format("{} at {}: {:08x}, expected 0 to 7fffffff", field, at, id));
}

Result<void> check_version(std::string_view body, ByteView bytes, std::string_view who) {
  const auto version = u32_at(bytes, 0);
  if (version == kProtocolVersion) return {};
  return fail(ErrorCode::kUnsupported,
              fmt::format("{} of {}: protocol version {}, expected {}", body, who, version, kProtocolVersion));
}

Result<std::string> network_at(std::string_view body, ByteView bytes, std::size_t at) {
  const auto name = text_at(body, "network name", bytes, at, kNameField);
  if (!name) return fail(name.error());
  if (name->empty()) return wrong_field(body, fmt::format("network name at {}: empty", at));
  return std::string(*name);
}

void put_name(std::span<std::uint8_t> out, std::size_t at, std::string_view name) {
  put_bytes(out, at, base::as_bytes(name.substr(0, kMaxNameLength)));
}

void put_network(std::span<std::uint8_t> out, std::size_t at, std::string_view name) {
  RUBICON_ASSERT(!name.empty() && name.size() <= kMaxNameLength && name.find('\0') == name.npos);
  put_name(out, at, name);
}

HostAddress address_at(ByteView bytes) {
  HostAddress address;
  const auto device = base::as_text(bytes.first(kDeviceField));
  address.device = device.substr(0, device.find('\0'));
  address.loopback = bytes[8] != 0;
  address.type = AddressType(u32_le_at(bytes, 12));
  std::copy_n(bytes.begin() + 16, address.ip.size(), address.ip.begin());
  address.port = u32_at(bytes, 20);
  return address;
}

void put_address(std::span<std::uint8_t> out, const HostAddress& address) {
  put_bytes(out, 0, base::as_bytes(std::string_view(address.device).substr(0, kDeviceField)));
  out[8] = address.loopback ? 1 : 0;
  put_u32_le(out, 12, static_cast<std::uint32_t>(address.type));
  put_bytes(out, 16, address.ip);
  put_u32(out, 20, address.port);
}

/// The 544 bytes that announcements and HOSTINFO have in common, from `at` on.
Result<HostRecord> read_host(std::string_view body, ByteView bytes, std::size_t at) {
  HostRecord host;
  const auto id = id_at(body, "host id", bytes, at);
  if (!id) return fail(id.error());
  host.id = *id;
  host.magic = u32_at(bytes, at + 4);
  const auto host_name = text_at(body, "host name", bytes, at + 8, kNameField);
  if (!host_name) return fail(host_name.error());
  host.host_name = *host_name;
  const auto full_name = text_at(body, "full name", bytes, at + 72, kNameField);
  if (!full_name) return fail(full_name.error());
  host.full_name = *full_name;
  const std::size_t addresses = bytes[at + 136];
  if (addresses > kMaxAddresses)
    return wrong_field(
        body, fmt::format("number of addresses at {}: {}, expected at most {}", at + 136, addresses, kMaxAddresses));
  for (std::size_t i = 0; i < addresses; ++i)
    host.addresses.push_back(address_at(bytes.subspan(at + kFirstAddress + i * kAddressSize, kAddressSize)));
  host.cluster = OwnerId{u32_at(bytes, at + 536)};
  host.flags = u32_at(bytes, at + 540);
  return host;
}

void put_host(std::span<std::uint8_t> out, const HostRecord& host) {
  RUBICON_ASSERT(host.addresses.size() <= kMaxAddresses);
  put_id(out, 0, host.id);
  put_u32(out, 4, host.magic);
  put_name(out, 8, host.host_name);
  put_name(out, 72, host.full_name);
  out[136] = static_cast<std::uint8_t>(host.addresses.size());
  for (std::size_t i = 0; i < host.addresses.size(); ++i)
    put_address(out.subspan(kFirstAddress + i * kAddressSize, kAddressSize), host.addresses[i]);
  put_id(out, 536, host.cluster);
  put_u32(out, 540, host.flags);
}

}  // namespace

Result<Announcement> read_announcement(ByteView datagram) {
  constexpr std::string_view kBody = "announcement";
  if (const auto size = expect_size(kBody, datagram, kAnnouncementSize); !size) return fail(size.error());
  const auto who = fmt::format("id {}", u32_at(datagram, 72));
  if (const auto version = check_version(kBody, datagram, who); !version) return fail(version.error());
  auto network = network_at(kBody, datagram, 8);
  if (!network) return fail(network.error());
  auto host = read_host(kBody, datagram, 72);
  if (!host) return fail(host.error());
  return Announcement{std::move(*network), std::move(*host)};
}

Bytes write(const Announcement& announcement) {
  Bytes out(kAnnouncementSize);
  put_u32(out, 0, kProtocolVersion);
  put_network(out, 8, announcement.network);
  put_host(std::span(out).subspan(72), announcement.host);
  return out;
}

Result<ConnectMessage> read_connect(ByteView bytes) {
  constexpr std::string_view kBody = "connect message";
  if (const auto size = expect_size(kBody, bytes, kConnectSize); !size) return fail(size.error());
  const auto who = fmt::format("id {}", u32_at(bytes, 4));
  if (const auto version = check_version(kBody, bytes, who); !version) return fail(version.error());
  const auto id = id_at(kBody, "id", bytes, 4);
  if (!id) return fail(id.error());
  auto network = network_at(kBody, bytes, 12);
  if (!network) return fail(network.error());
  return ConnectMessage{*id, u32_at(bytes, 8), std::move(*network)};
}

Bytes write(const ConnectMessage& message) {
  Bytes out(kConnectSize);
  put_u32(out, 0, kProtocolVersion);
  put_id(out, 4, message.id);
  put_u32(out, 8, message.flags);
  put_network(out, 12, message.network);
  return out;
}

Result<HostRecordMessage> read_host_info(ByteView body) {
  constexpr std::string_view kBody = "HOSTINFO";
  if (const auto size = expect_size(kBody, body, kHostRecordSize + 8); !size) return fail(size.error());
  auto host = read_host(kBody, body, 0);
  if (!host) return fail(host.error());
  return HostRecordMessage{std::move(*host), body[kHostRecordSize] != 0};
}

Bytes write(const HostRecordMessage& message) {
  Bytes out(kHostRecordSize + 8);
  put_host(out, message.host);
  out[kHostRecordSize] = message.cached ? 1 : 0;
  return out;
}

std::string to_string(Port port) {
  switch (port) {
    case Port::kRouting: return "ROUTING";
    case Port::kTrace: return "TRACE";
    case Port::kTraceReply: return "TRACE_REPLY";
    case Port::kSubscribe: return "SUBSCRIBE";
    case Port::kUnsubscribe: return "UNSUBSCRIBE";
    case Port::kPush: return "PUSH_TUPLE";
    case Port::kDeadHost: return "DEAD_HOST";
    case Port::kSetRemote: return "SET_REMOTE";
    case Port::kTimeSync: return "TIMESYNC";
    case Port::kQueryHost: return "QUERY_HOST";
    case Port::kHostInfo: return "HOSTINFO";
    case Port::kAcks: return "ACKS";
    case Port::kSetAppend: return "SET_APPEND";
    case Port::kPushAppended: return "PUSH_APPENDED";
    case Port::kHello: return "HELLO";
    case Port::kReply: return "REPLY";
    case Port::kSummary: return "SUMMARY";
    case Port::kSnapshot: return "SNAPSHOT";
  }
  return fmt::format("port {}", static_cast<unsigned>(port));
}

Result<PackageHeader> read_package_header(ByteView bytes) {
  constexpr std::string_view kBody = "package";
  if (bytes.size() < kHeaderSize)
    return wrong_field(kBody, fmt::format("{} bytes, the header has {}", bytes.size(), kHeaderSize));
  if (u32_at(bytes, 0) != kSync)
    return wrong_field(kBody, fmt::format("sync at 0: {:08x}, expected {:08x}", u32_at(bytes, 0), kSync));
  PackageHeader header;
  header.id = u32_at(bytes, 4);
  header.counter = u32_at(bytes, 8);
  header.ack_id = u32_at(bytes, 12);
  header.flags = u16_at(bytes, 16);
  header.routing = Routing(bytes[18]);
  header.hops = bytes[19];
  header.source = OwnerId{u32_at(bytes, 20)};
  header.destination = OwnerId{u32_at(bytes, 24)};
  header.port = Port(u16_at(bytes, 28));
  header.length = u16_at(bytes, 30);
  header.fragments = u16_at(bytes, 32);
  header.message = u16_at(bytes, 34);
  header.fragment = u16_at(bytes, 36);
  for (const auto& [field, at] : {std::pair("package id", 4U), std::pair("ack id", 12U), std::pair("source", 20U)}) {
    if (const auto id = id_at(kBody, field, bytes, at); !id) return fail(id.error());
  }
  if (header.destination != kEveryone) {
    if (const auto id = id_at(kBody, "destination", bytes, 24); !id) return fail(id.error());
  }
  if (header.length > kMaxBody)
    return wrong_field(kBody, fmt::format("length at 30: {}, expected at most {}", header.length, kMaxBody));
  return header;
}

void append_package(Bytes& out, const PackageHeader& header, ByteView body) {
  RUBICON_ASSERT(body.size() <= kMaxBody);
  const auto begin = out.size();
  out.resize(begin + kHeaderSize);
  const auto head = std::span(out).subspan(begin);
  put_u32(head, 0, kSync);
  put_u32(head, 4, header.id);
  put_u32(head, 8, header.counter);
  put_u32(head, 12, header.ack_id);
  put_u16(head, 16, header.flags);
  head[18] = static_cast<std::uint8_t>(header.routing);
  head[19] = header.hops;
  put_id(head, 20, header.source);
  put_id(head, 24, header.destination);
  put_u16(head, 28, static_cast<std::uint16_t>(header.port));
  put_u16(head, 30, static_cast<std::uint16_t>(body.size()));
  put_u16(head, 32, header.fragments);
  put_u16(head, 34, header.message);
  put_u16(head, 36, header.fragment);
  out.insert(out.end(), body.begin(), body.end());
}

void restamp_package(std::span<std::uint8_t> package, std::uint32_t id, std::uint32_t counter) {
  RUBICON_ASSERT(package.size() >= kHeaderSize);
  put_u32(package, 4, id);
  put_u32(package, 8, counter);
}

namespace {

constexpr std::size_t kRoutingHeader = 12, kRouteSize = 14;
constexpr std::size_t kTraceSize = 64;

RouteEntry route_at(ByteView bytes) {
  return {OwnerId{u32_at(bytes, 0)}, u32_at(bytes, 4), u32_at(bytes, 8), bytes[12], bytes[13]};
}

void put_route(std::span<std::uint8_t> out, const RouteEntry& entry) {
  put_id(out, 0, entry.id);
  put_u32(out, 4, entry.sequence);
  put_u32(out, 8, entry.magic);
  out[12] = entry.hops;
  out[13] = entry.connections;
}

Result<void> check_node_id(std::string_view body, std::string_view field, std::uint32_t id) {
  if (id <= kMaxId) return {};
  return wrong_field(body, fmt::format("{}: {:08x}, expected 0 to 7fffffff", field, id));
}

}  // namespace

Result<RoutingPage> read_routing_page(ByteView body) {
  constexpr std::string_view kBody = "ROUTING";
  if (body.size() < kRoutingHeader)
    return wrong_field(kBody, fmt::format("{} bytes, expected at least {}", body.size(), kRoutingHeader));
  const std::size_t entries = u16_at(body, 4);
  if (entries > kMaxRoutesOfPage)
    return wrong_field(kBody, fmt::format("entries at 4: {}, expected at most {}", entries, kMaxRoutesOfPage));
  if (const auto size = expect_size(kBody, body, kRoutingHeader + entries * kRouteSize); !size)
    return fail(size.error());
  RoutingPage page{u16_at(body, 0), u16_at(body, 2), u32_at(body, 8), {}};
  if (page.page >= page.pages)
    return wrong_field(kBody, fmt::format("page at 0: {} of {}, expected less", page.page, page.pages));
  for (std::size_t i = 0; i < entries; ++i) {
    const auto entry = route_at(body.subspan(kRoutingHeader + i * kRouteSize, kRouteSize));
    if (const auto id = check_node_id(kBody, fmt::format("id of entry {}", i), number(entry.id)); !id)
      return fail(id.error());
    page.entries.push_back(entry);
  }
  return page;
}

Bytes write(const RoutingPage& page) {
  RUBICON_ASSERT(page.entries.size() <= kMaxRoutesOfPage && page.page < page.pages);
  Bytes out(kRoutingHeader + page.entries.size() * kRouteSize);
  put_u16(out, 0, page.page);
  put_u16(out, 2, page.pages);
  put_u16(out, 4, static_cast<std::uint16_t>(page.entries.size()));
  put_u32(out, 8, page.sequence);
  for (std::size_t i = 0; i < page.entries.size(); ++i)
    put_route(std::span(out).subspan(kRoutingHeader + i * kRouteSize, kRouteSize), page.entries[i]);
  return out;
}

Result<Acks> read_acks(ByteView body) {
  constexpr std::string_view kBody = "ACKS";
  if (body.size() < 4) return wrong_field(kBody, fmt::format("{} bytes, expected at least 4", body.size()));
  const auto count = u32_at(body, 0);
  if (count > kMaxReadAcks)
    return wrong_field(kBody, fmt::format("count at 0: {}, expected at most {}", count, kMaxReadAcks));
  if (const auto size = expect_size(kBody, body, 4 + std::size_t{count} * 4); !size) return fail(size.error());
  Acks acks;
  for (std::size_t i = 0; i < count; ++i) acks.ids.push_back(u32_at(body, 4 + i * 4));
  return acks;
}

Bytes write(const Acks& acks) {
  RUBICON_ASSERT(acks.ids.size() <= kMaxReadAcks);
  Bytes out(4 + acks.ids.size() * 4);
  put_u32(out, 0, static_cast<std::uint32_t>(acks.ids.size()));
  for (std::size_t i = 0; i < acks.ids.size(); ++i) put_u32(out, 4 + i * 4, acks.ids[i]);
  return out;
}

Result<QueryHost> read_query_host(ByteView body) {
  constexpr std::string_view kBody = "QUERY_HOST";
  if (const auto size = expect_size(kBody, body, 8); !size) return fail(size.error());
  if (const auto id = check_node_id(kBody, "asker at 0", u32_at(body, 0)); !id) return fail(id.error());
  return QueryHost{OwnerId{u32_at(body, 0)}, u32_at(body, 4)};
}

Bytes write(const QueryHost& query) {
  Bytes out(8);
  put_id(out, 0, query.asker);
  put_u32(out, 4, query.magic);
  return out;
}

Result<DeadHost> read_dead_host(ByteView body) {
  constexpr std::string_view kBody = "DEAD_HOST";
  if (const auto size = expect_size(kBody, body, 8); !size) return fail(size.error());
  if (const auto id = check_node_id(kBody, "id at 0", u32_at(body, 0)); !id) return fail(id.error());
  return DeadHost{OwnerId{u32_at(body, 0)}, DeathReason(u32_at(body, 4))};
}

Bytes write(const DeadHost& dead) {
  Bytes out(8);
  put_id(out, 0, dead.id);
  put_u32(out, 4, static_cast<std::uint32_t>(dead.reason));
  return out;
}

Result<TimeSync> read_time_sync(ByteView body) {
  constexpr std::string_view kBody = "TIMESYNC";
  if (const auto size = expect_size(kBody, body, 12); !size) return fail(size.error());
  const TimeSync time{u32_at(body, 0), u32_at(body, 4), body[8] != 0};
  if (time.microseconds > 999999)
    return wrong_field(kBody, fmt::format("microseconds at 4: {}, expected at most 999999", time.microseconds));
  return time;
}

Bytes write(const TimeSync& time) {
  Bytes out(12);
  put_u32(out, 0, time.seconds);
  put_u32(out, 4, time.microseconds);
  out[8] = time.master ? 1 : 0;
  return out;
}

Result<Trace> read_trace(ByteView body) {
  constexpr std::string_view kBody = "TRACE";
  if (const auto size = expect_size(kBody, body, kTraceSize); !size) return fail(size.error());
  const auto hops = u32_at(body, 0);
  if (hops > kMaxTrace) return wrong_field(kBody, fmt::format("hops at 0: {}, expected at most {}", hops, kMaxTrace));
  Trace trace;
  for (std::size_t i = 0; i < hops; ++i) {
    const auto id = u32_at(body, 4 + i * 4);
    if (const auto good = check_node_id(kBody, fmt::format("id {}", i), id); !good) return fail(good.error());
    trace.path.push_back(OwnerId{id});
  }
  return trace;
}

Bytes write(const Trace& trace) {
  RUBICON_ASSERT(trace.path.size() <= kMaxTrace);
  Bytes out(kTraceSize);
  put_u32(out, 0, static_cast<std::uint32_t>(trace.path.size()));
  for (std::size_t i = 0; i < trace.path.size(); ++i) put_id(out, 4 + i * 4, trace.path[i]);
  return out;
}

}  // namespace rubicon::tuples::peis
