#include "networks/knx/wire/frame.h"

#include <fmt/format.h>

#include "base/assert.h"

namespace rubicon::networks::knx::wire {

namespace {

constexpr std::uint8_t kVersion = 0x10;

std::string_view name_of(ServiceCode code) {
  switch (code) {
    case ServiceCode::kSearchRequest: return "SEARCH_REQUEST";
    case ServiceCode::kSearchResponse: return "SEARCH_RESPONSE";
    case ServiceCode::kDescriptionRequest: return "DESCRIPTION_REQUEST";
    case ServiceCode::kDescriptionResponse: return "DESCRIPTION_RESPONSE";
    case ServiceCode::kConnectRequest: return "CONNECT_REQUEST";
    case ServiceCode::kConnectResponse: return "CONNECT_RESPONSE";
    case ServiceCode::kConnectionStateRequest: return "CONNECTIONSTATE_REQUEST";
    case ServiceCode::kConnectionStateResponse: return "CONNECTIONSTATE_RESPONSE";
    case ServiceCode::kDisconnectRequest: return "DISCONNECT_REQUEST";
    case ServiceCode::kDisconnectResponse: return "DISCONNECT_RESPONSE";
    case ServiceCode::kSearchRequestExtended: return "SEARCH_REQUEST_EXT";
    case ServiceCode::kSearchResponseExtended: return "SEARCH_RESPONSE_EXT";
    case ServiceCode::kDeviceConfigurationRequest: return "DEVICE_CONFIGURATION_REQUEST";
    case ServiceCode::kDeviceConfigurationAck: return "DEVICE_CONFIGURATION_ACK";
    case ServiceCode::kTunnellingRequest: return "TUNNELLING_REQUEST";
    case ServiceCode::kTunnellingAck: return "TUNNELLING_ACK";
    case ServiceCode::kFeatureGet: return "TUNNELLING_FEATURE_GET";
    case ServiceCode::kFeatureResponse: return "TUNNELLING_FEATURE_RESPONSE";
    case ServiceCode::kFeatureSet: return "TUNNELLING_FEATURE_SET";
    case ServiceCode::kFeatureNotice: return "TUNNELLING_FEATURE_INFO";
    case ServiceCode::kRoutingIndication: return "ROUTING_INDICATION";
    case ServiceCode::kRoutingLostMessage: return "ROUTING_LOST_MESSAGE";
    case ServiceCode::kRoutingBusy: return "ROUTING_BUSY";
    case ServiceCode::kRoutingSystemBroadcast: return "ROUTING_SYSTEM_BROADCAST";
    case ServiceCode::kSecureWrapper: return "SECURE_WRAPPER";
    case ServiceCode::kSessionRequest: return "SESSION_REQUEST";
    case ServiceCode::kSessionResponse: return "SESSION_RESPONSE";
    case ServiceCode::kSessionAuthenticate: return "SESSION_AUTHENTICATE";
    case ServiceCode::kSessionStatus: return "SESSION_STATUS";
    case ServiceCode::kTimerNotify: return "TIMER_NOTIFY";
  }
  return {};
}

}  // namespace

std::string to_string(ServiceCode code) {
  const auto name = name_of(code);
  return name.empty() ? fmt::format("service {:04x}", static_cast<unsigned>(code)) : std::string(name);
}

Result<std::size_t> frame_size(ByteView stream) {
  if (!stream.empty() && stream[0] != kHeaderSize)
    return fail(ErrorCode::kInvalid, fmt::format("KNXnet/IP header of size {}, expected 6", stream[0]));
  if (stream.size() > 1 && stream[1] != kVersion)
    return fail(ErrorCode::kInvalid, fmt::format("KNXnet/IP version {:02x}, expected 10", stream[1]));
  if (stream.size() < kHeaderSize) return 0;
  const auto total = u16_at(stream, 4);
  if (total < kHeaderSize)
    return fail(ErrorCode::kInvalid, fmt::format("KNXnet/IP total length {}, expected at least 6", total));
  return total;
}

Result<Frame> read_frame(ByteView bytes) {
  if (bytes.size() < kHeaderSize)
    return fail(ErrorCode::kInvalid, fmt::format("{} bytes, a KNXnet/IP header has 6", bytes.size()));
  const auto total = frame_size(bytes);
  if (!total) return fail(total.error());
  if (*total != bytes.size())
    return fail(ErrorCode::kInvalid, fmt::format("KNXnet/IP total length {}, but {} bytes came", *total, bytes.size()));
  return Frame{ServiceCode(u16_at(bytes, 2)), bytes.subspan(kHeaderSize)};
}

void open_frame(Bytes& out, ServiceCode service) {
  const auto code = static_cast<std::uint16_t>(service);
  const std::uint8_t header[] = {
      kHeaderSize, kVersion, static_cast<std::uint8_t>(code >> 8), static_cast<std::uint8_t>(code & 0xff), 0, 0};
  out.insert(out.end(), std::begin(header), std::end(header));
}

void close_frame(Bytes& out, std::size_t begin) {
  const auto total = out.size() - begin;
  RUBICON_ASSERT(total >= kHeaderSize && total <= 0xffff);
  out[begin + 4] = static_cast<std::uint8_t>(total >> 8);
  out[begin + 5] = static_cast<std::uint8_t>(total & 0xff);
}

}  // namespace rubicon::networks::knx::wire
