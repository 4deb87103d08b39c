#pragma once

#include <cstdint>
#include <string>

#include "base/bytes.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::wire {

/// Services of KNXnet/IP (KNX 3/8/2 to 3/8/5, 3/8/9). Frames may have service codes that are not named here.
enum class ServiceCode : std::uint16_t {
  kSearchRequest = 0x0201,
  kSearchResponse = 0x0202,
  kDescriptionRequest = 0x0203,
  kDescriptionResponse = 0x0204,
  kConnectRequest = 0x0205,
  kConnectResponse = 0x0206,
  kConnectionStateRequest = 0x0207,
  kConnectionStateResponse = 0x0208,
  kDisconnectRequest = 0x0209,
  kDisconnectResponse = 0x020a,
  kSearchRequestExtended = 0x020b,
  kSearchResponseExtended = 0x020c,
  kDeviceConfigurationRequest = 0x0310,
  kDeviceConfigurationAck = 0x0311,
  kTunnellingRequest = 0x0420,
  kTunnellingAck = 0x0421,
  kFeatureGet = 0x0422,
  kFeatureResponse = 0x0423,
  kFeatureSet = 0x0424,
  kFeatureNotice = 0x0425,  ///< TUNNELLING_FEATURE_INFO
  kRoutingIndication = 0x0530,
  kRoutingLostMessage = 0x0531,
  kRoutingBusy = 0x0532,
  kRoutingSystemBroadcast = 0x0533,
  kSecureWrapper = 0x0950,
  kSessionRequest = 0x0951,
  kSessionResponse = 0x0952,
  kSessionAuthenticate = 0x0953,
  kSessionStatus = 0x0954,
  kTimerNotify = 0x0955,
};

/// `TUNNELLING_REQUEST`; `service 0538` for codes without a name.
std::string to_string(ServiceCode code);

/// Length of the KNXnet/IP header: size 06, version 10, service, total length (KNX 3/8/2).
constexpr std::size_t kHeaderSize = 6;

/// A 16 bit number, big endian as all numbers of KNX.
inline std::uint16_t u16_at(ByteView bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

/// Service and body of a KNXnet/IP frame. Refers to the bytes it was read from.
struct Frame {
  ServiceCode service{};
  ByteView body;
};

/// Reads one complete frame. kInvalid: too short, a header of another size or version, a total length other than
/// bytes.size().
Result<Frame> read_frame(ByteView bytes);
/// Total length of the frame at the start of a stream, at least kHeaderSize; 0 = not known yet. kInvalid: this is not a
/// header, so the rest of the stream cannot be read.
Result<std::size_t> frame_size(ByteView stream);

/// Appends a header; close_frame() then writes the total length of what was appended since `begin`.
void open_frame(Bytes& out, ServiceCode service);
void close_frame(Bytes& out, std::size_t begin = 0);

}  // namespace rubicon::networks::knx::wire
