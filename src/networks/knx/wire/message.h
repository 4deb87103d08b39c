#pragma once

#include <variant>
#include <vector>

#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/description.h"
#include "networks/knx/wire/frame.h"

namespace rubicon::networks::knx::wire {

/// Bodies of the supported services (KNX 3/8/2 to 3/8/5). Views refer to the bytes they were read from.

struct SearchRequest {
  Hpai discovery;
  bool extended = false;
  std::vector<Srp> parameters{};  ///< of the extended form
  friend bool operator==(const SearchRequest&, const SearchRequest&) = default;
};
struct SearchResponse {
  Hpai control;
  bool extended = false;
  std::vector<Dib> dibs{};
  friend bool operator==(const SearchResponse&, const SearchResponse&) = default;
};
struct DescriptionRequest {
  Hpai control;
  friend bool operator==(const DescriptionRequest&, const DescriptionRequest&) = default;
};
struct DescriptionResponse {
  std::vector<Dib> dibs;
  friend bool operator==(const DescriptionResponse&, const DescriptionResponse&) = default;
};
struct ConnectRequest {
  Hpai control, data;
  Cri cri{};
  friend bool operator==(const ConnectRequest&, const ConnectRequest&) = default;
};
struct ConnectResponse {
  std::uint8_t channel = 0, status = 0;
  Hpai data{};  ///< this and the next member only with status 00
  Crd crd{};
  friend bool operator==(const ConnectResponse&, const ConnectResponse&) = default;
};
struct ConnectionStateRequest {
  std::uint8_t channel = 0;
  Hpai control;
  friend bool operator==(const ConnectionStateRequest&, const ConnectionStateRequest&) = default;
};
struct ConnectionStateResponse {
  std::uint8_t channel = 0, status = 0;
  friend bool operator==(const ConnectionStateResponse&, const ConnectionStateResponse&) = default;
};
struct DisconnectRequest {
  std::uint8_t channel = 0;
  Hpai control;
  friend bool operator==(const DisconnectRequest&, const DisconnectRequest&) = default;
};
struct DisconnectResponse {
  std::uint8_t channel = 0, status = 0;
  friend bool operator==(const DisconnectResponse&, const DisconnectResponse&) = default;
};
/// TUNNELLING_REQUEST and DEVICE_CONFIGURATION_REQUEST.
struct ConnectionRequest {
  ServiceCode service = ServiceCode::kTunnellingRequest;
  ConnectionHeader header;
  ByteView cemi;
};
/// TUNNELLING_ACK and DEVICE_CONFIGURATION_ACK.
struct ConnectionAck {
  ServiceCode service = ServiceCode::kTunnellingAck;
  ConnectionHeader header;
};
/// TUNNELLING_FEATURE_GET, _RESPONSE, _SET and _INFO.
struct FeatureMessage {
  ServiceCode service = ServiceCode::kFeatureGet;
  ConnectionHeader header;
  std::uint8_t feature = 0;  ///< 01..08 (Feature)
  std::uint8_t code = 0;     ///< return code of a response, else 00
  ByteView value;            ///< written without padding; some servers pad it to an even length
};
enum class Feature : std::uint8_t {
  kSupportedEmi = 1,
  kDeviceDescriptor = 2,
  kBusConnection = 3,
  kManufacturer = 4,
  kActiveEmi = 5,
  kAddress = 6,
  kMaxApdu = 7,
  kNotices = 8
};
struct RoutingIndication {
  ByteView cemi;
  bool system_broadcast = false;  ///< ROUTING_SYSTEM_BROADCAST
};
struct RoutingLostMessage {
  std::uint8_t device_state = 0;
  std::uint16_t lost = 0;  ///< messages
};
struct RoutingBusy {
  std::uint8_t device_state = 0;
  std::uint16_t wait = 0;     ///< ms
  std::uint16_t control = 0;  ///< 0 = all devices wait
};
/// A well formed frame of a service whose body is not read, such as a secure service.
struct OtherService {
  ServiceCode service{};
  ByteView body;
};

using Message = std::variant<OtherService, SearchRequest, SearchResponse, DescriptionRequest, DescriptionResponse,
                             ConnectRequest, ConnectResponse, ConnectionStateRequest, ConnectionStateResponse,
                             DisconnectRequest, DisconnectResponse, ConnectionRequest, ConnectionAck, FeatureMessage,
                             RoutingIndication, RoutingLostMessage, RoutingBusy>;

/// Reads a complete frame with its header. kInvalid names the service and the error; kUnsupported: an unknown type of
/// connection.
Result<Message> read_message(ByteView frame);
Result<Message> read_message(const Frame& frame);

/// The complete frame.
Bytes write(const Message& message);

/// Replaces the content of `out` and reuses its memory.
void write_connection_request(Bytes& out, ServiceCode service, const ConnectionHeader& header, ByteView cemi);
void write_connection_ack(Bytes& out, ServiceCode service, const ConnectionHeader& header);

}  // namespace rubicon::networks::knx::wire
