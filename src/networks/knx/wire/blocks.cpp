#include "networks/knx/wire/blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/assert.h"

namespace rubicon::networks::knx::wire {

StatusMeaning meaning_of(std::uint8_t status) {
  switch (status) {
    case status::kOk: return {"ok", Remedy::kNone};
    case 0x01: return {"the interface does not support this transport protocol", Remedy::kConfiguration};
    case 0x02: return {"the interface does not support this KNXnet/IP version", Remedy::kConfiguration};
    case 0x04: return {"a sequence number was out of order", Remedy::kRetry};
    case 0x0f: return {"the interface reports an unspecified error", Remedy::kRetry};
    case status::kUnknownConnection: return {"the interface does not know the connection", Remedy::kReconnect};
    case status::kConnectionType:
      return {"the interface does not offer this type of connection (does it require KNX IP Secure?)",
              Remedy::kConfiguration};
    case 0x23: return {"the interface does not support an option of the connection", Remedy::kConfiguration};
    case status::kNoMoreConnections: return {"all tunnels of the interface are in use", Remedy::kWaitForSlot};
    case status::kNoUniqueConnection:
      return {"a tunnel is free, but its individual address is in use", Remedy::kWaitForSlot};
    case 0x26: return {"the interface reports an error of the data connection", Remedy::kReconnect};
    case status::kBusDown: return {"the interface has no connection to the KNX bus", Remedy::kBusDown};
    case status::kUnauthorised: return {"the interface does not authorise this user", Remedy::kConfiguration};
    case status::kLayer: return {"the interface does not support this tunnelling layer", Remedy::kConfiguration};
    case 0x2d: return {"the interface has no tunnel with the requested individual address", Remedy::kConfiguration};
    case status::kAddressInUse: return {"the requested tunnel address is in use", Remedy::kWaitForSlot};
    default: return {"unknown status", Remedy::kRetry};
  }
}

std::string describe_status(std::uint8_t status) {
  return fmt::format("{} (status {:02X})", meaning_of(status).meaning, status);
}

namespace {

constexpr std::uint8_t kHpaiSize = 8, kConnectionHeaderSize = 4;
constexpr std::uint8_t kMandatory = 0x80;

auto wrong(std::string_view block, std::string_view what) {
  return fail(ErrorCode::kInvalid, fmt::format("{}: {}", block, what));
}
auto short_block(std::string_view block) {
  return wrong(block, "goes beyond the end of the frame");
}
auto wrong_length(std::string_view block, unsigned length, unsigned expected) {
  return wrong(block, fmt::format("length {}, expected {}", length, expected));
}

/// Consumes a block whose first byte is its length.
Result<ByteView> take_block(base::ByteReader& reader, std::string_view name) {
  const auto length = reader.u8();
  if (!reader.ok()) return short_block(name);
  if (length < 2) return wrong(name, fmt::format("length {}, expected at least 2", length));
  const auto content = reader.take(length - std::size_t{1});
  if (!reader.ok()) return short_block(name);
  return content;
}

}  // namespace

void write_u16(Bytes& out, std::uint16_t value) {
  out.push_back(static_cast<std::uint8_t>(value >> 8));
  out.push_back(static_cast<std::uint8_t>(value & 0xff));
}

Hpai udp_hpai(std::string_view address, std::uint16_t port) {
  Hpai hpai;
  const char* at = address.data();
  const char* const end = at + address.size();
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [next, error] = std::from_chars(at, end, hpai.address[i]);
    const bool last = i == 3;
    if (error != std::errc() || (last ? next != end : next == end || *next != '.')) return {};
    if (!last) at = next + 1;
  }
  hpai.port = port;
  return hpai;
}

std::string address_text(const Hpai& hpai) {
  return fmt::format("{}.{}.{}.{}", hpai.address[0], hpai.address[1], hpai.address[2], hpai.address[3]);
}

Result<Hpai> read_hpai(base::ByteReader& reader) {
  const auto length = reader.u8();
  const auto protocol = reader.u8();
  const auto address = reader.take(4);
  const auto port = reader.u16_be();
  if (!reader.ok()) return short_block("HPAI");
  if (length != kHpaiSize) return wrong_length("HPAI", length, kHpaiSize);
  if (protocol != 1 && protocol != 2) return wrong("HPAI", fmt::format("protocol {}, expected 1 or 2", protocol));
  Hpai hpai{HostProtocol(protocol), {}, port};
  std::copy(address.begin(), address.end(), hpai.address.begin());
  return hpai;
}

void write(Bytes& out, const Hpai& hpai) {
  out.push_back(kHpaiSize);
  out.push_back(static_cast<std::uint8_t>(hpai.protocol));
  out.insert(out.end(), hpai.address.begin(), hpai.address.end());
  write_u16(out, hpai.port);
}

Result<ConnectionHeader> read_connection_header(base::ByteReader& reader) {
  const auto length = reader.u8();
  ConnectionHeader header;
  header.channel = reader.u8();
  header.sequence = reader.u8();
  header.status = reader.u8();
  if (!reader.ok()) return short_block("connection header");
  if (length != kConnectionHeaderSize) return wrong_length("connection header", length, kConnectionHeaderSize);
  return header;
}

void write(Bytes& out, const ConnectionHeader& header) {
  const std::uint8_t bytes[] = {kConnectionHeaderSize, header.channel, header.sequence, header.status};
  out.insert(out.end(), std::begin(bytes), std::end(bytes));
}

Result<Cri> read_cri(base::ByteReader& reader) {
  const auto block = take_block(reader, "CRI");
  if (!block) return fail(block.error());
  const auto& content = *block;
  if (content[0] == static_cast<std::uint8_t>(ConnectionType::kDeviceManagement))
    return Cri{ConnectionType::kDeviceManagement, TunnelLayer::kLink, std::nullopt};
  if (content[0] != static_cast<std::uint8_t>(ConnectionType::kTunnel))
    return fail(ErrorCode::kUnsupported, fmt::format("CRI: connection type {:02x}", content[0]));
  if (content.size() != 3 && content.size() != 5)
    return wrong("CRI", fmt::format("length {} of a tunnel, expected 4 or 6", content.size() + 1));
  Cri cri{ConnectionType::kTunnel, TunnelLayer(content[1]), std::nullopt};
  if (content.size() == 5) cri.wanted = IndividualAddress(static_cast<std::uint16_t>(content[3] << 8 | content[4]));
  return cri;
}

void write(Bytes& out, const Cri& cri) {
  const bool tunnel = cri.type == ConnectionType::kTunnel;
  out.push_back(!tunnel ? 2 : cri.wanted ? 6 : 4);
  out.push_back(static_cast<std::uint8_t>(cri.type));
  if (!tunnel) return;
  out.push_back(static_cast<std::uint8_t>(cri.layer));
  out.push_back(0);
  if (cri.wanted) write_u16(out, number(*cri.wanted));
}

Result<Crd> read_crd(base::ByteReader& reader) {
  const auto block = take_block(reader, "CRD");
  if (!block) return fail(block.error());
  const auto& content = *block;
  if (content[0] == static_cast<std::uint8_t>(ConnectionType::kDeviceManagement))
    return Crd{ConnectionType::kDeviceManagement, {}};
  if (content[0] != static_cast<std::uint8_t>(ConnectionType::kTunnel))
    return fail(ErrorCode::kUnsupported, fmt::format("CRD: connection type {:02x}", content[0]));
  if (content.size() != 3) return wrong_length("CRD", static_cast<unsigned>(content.size() + 1), 4);
  return Crd{ConnectionType::kTunnel, IndividualAddress(static_cast<std::uint16_t>(content[1] << 8 | content[2]))};
}

void write(Bytes& out, const Crd& crd) {
  const bool tunnel = crd.type == ConnectionType::kTunnel;
  out.push_back(tunnel ? 4 : 2);
  out.push_back(static_cast<std::uint8_t>(crd.type));
  if (tunnel) write_u16(out, number(crd.address));
}

Result<std::vector<Srp>> read_srps(base::ByteReader& reader) {
  std::vector<Srp> srps;
  while (reader.remaining() > 0) {
    const auto block = take_block(reader, "SRP");
    if (!block) return fail(block.error());
    Srp srp{Srp::Type(block->front() & 0x7f), (block->front() & kMandatory) != 0, {}};
    srp.content.assign(block->begin() + 1, block->end());
    srps.push_back(std::move(srp));
  }
  return srps;
}

void write(Bytes& out, const Srp& srp) {
  RUBICON_ASSERT(srp.content.size() <= 253);
  out.push_back(static_cast<std::uint8_t>(srp.content.size() + 2));
  out.push_back(static_cast<std::uint8_t>(static_cast<unsigned>(srp.type) | (srp.mandatory ? kMandatory : 0U)));
  out.insert(out.end(), srp.content.begin(), srp.content.end());
}

}  // namespace rubicon::networks::knx::wire
