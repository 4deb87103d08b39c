#include <algorithm>

#include "base/assert.h"
#include "tuples/peis/fields.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

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
