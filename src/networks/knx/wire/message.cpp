#include "networks/knx/wire/message.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::knx::wire {

namespace {

using base::ByteReader;

template <class Body>
Result<Message> message(Result<Body> body) {
  if (!body) return fail(std::move(body.error()));
  return Message(std::move(*body));
}

auto short_body() {
  return fail(ErrorCode::kInvalid, "body: too short");
}

Result<SearchRequest> read_search_request(ByteReader& reader, bool extended) {
  const auto discovery = read_hpai(reader);
  if (!discovery) return fail(discovery.error());
  SearchRequest request{*discovery, extended, {}};
  if (!extended) return request;
  auto parameters = read_srps(reader);
  if (!parameters) return fail(parameters.error());
  request.parameters = std::move(*parameters);
  return request;
}

Result<SearchResponse> read_search_response(ByteReader& reader, bool extended) {
  const auto control = read_hpai(reader);
  if (!control) return fail(control.error());
  auto dibs = read_dibs(reader);
  if (!dibs) return fail(dibs.error());
  return SearchResponse{*control, extended, std::move(*dibs)};
}

Result<DescriptionRequest> read_description_request(ByteReader& reader) {
  const auto control = read_hpai(reader);
  if (!control) return fail(control.error());
  return DescriptionRequest{*control};
}

Result<DescriptionResponse> read_description_response(ByteReader& reader) {
  auto dibs = read_dibs(reader);
  if (!dibs) return fail(dibs.error());
  return DescriptionResponse{std::move(*dibs)};
}

Result<ConnectRequest> read_connect_request(ByteReader& reader) {
  const auto control = read_hpai(reader);
  if (!control) return fail(control.error());
  const auto data = read_hpai(reader);
  if (!data) return fail(data.error());
  const auto cri = read_cri(reader);
  if (!cri) return fail(cri.error());
  return ConnectRequest{*control, *data, *cri};
}

/// If the status is an error, the body ends after it.
Result<ConnectResponse> read_connect_response(ByteReader& reader) {
  ConnectResponse response;
  response.channel = reader.u8();
  response.status = reader.u8();
  if (!reader.ok()) return short_body();
  if (response.status != 0) return response;
  const auto data = read_hpai(reader);
  if (!data) return fail(data.error());
  const auto crd = read_crd(reader);
  if (!crd) return fail(crd.error());
  response.data = *data;
  response.crd = *crd;
  return response;
}

template <class Body>
Result<Body> read_channel_request(ByteReader& reader) {
  const auto channel = reader.u8();
  reader.skip(1);
  if (!reader.ok()) return short_body();
  const auto control = read_hpai(reader);
  if (!control) return fail(control.error());
  return Body{channel, *control};
}

template <class Body>
Result<Body> read_channel_response(ByteReader& reader) {
  const auto channel = reader.u8(), status = reader.u8();
  if (!reader.ok()) return short_body();
  return Body{channel, status};
}

Result<ConnectionRequest> read_connection_request(ServiceCode service, ByteReader& reader) {
  const auto header = read_connection_header(reader);
  if (!header) return fail(header.error());
  return ConnectionRequest{service, *header, reader.take(reader.remaining())};
}

Result<ConnectionAck> read_connection_ack(ServiceCode service, ByteReader& reader) {
  const auto header = read_connection_header(reader);
  if (!header) return fail(header.error());
  return ConnectionAck{service, *header};
}

Result<FeatureMessage> read_feature(ServiceCode service, ByteReader& reader) {
  const auto header = read_connection_header(reader);
  if (!header) return fail(header.error());
  FeatureMessage feature{service, *header, reader.u8(), reader.u8(), {}};
  if (!reader.ok()) return short_body();
  feature.value = reader.take(reader.remaining());
  return feature;
}

Result<void> of_length(ByteReader& reader, unsigned expected) {
  const auto length = reader.u8();
  if (!reader.ok() || length == expected) return {};
  return fail(ErrorCode::kInvalid, fmt::format("body: length {}, expected {}", length, expected));
}

Result<RoutingLostMessage> read_lost(ByteReader& reader) {
  if (auto right = of_length(reader, 4); !right) return fail(right.error());
  RoutingLostMessage lost{reader.u8(), reader.u16_be()};
  if (!reader.ok()) return short_body();
  return lost;
}

Result<RoutingBusy> read_busy(ByteReader& reader) {
  if (auto right = of_length(reader, 6); !right) return fail(right.error());
  RoutingBusy busy{reader.u8(), reader.u16_be(), reader.u16_be()};
  if (!reader.ok()) return short_body();
  return busy;
}

Result<Message> read_body(const Frame& frame) {
  ByteReader reader(frame.body);
  switch (frame.service) {
    case ServiceCode::kSearchRequest: return message(read_search_request(reader, false));
    case ServiceCode::kSearchRequestExtended: return message(read_search_request(reader, true));
    case ServiceCode::kSearchResponse: return message(read_search_response(reader, false));
    case ServiceCode::kSearchResponseExtended: return message(read_search_response(reader, true));
    case ServiceCode::kDescriptionRequest: return message(read_description_request(reader));
    case ServiceCode::kDescriptionResponse: return message(read_description_response(reader));
    case ServiceCode::kConnectRequest: return message(read_connect_request(reader));
    case ServiceCode::kConnectResponse: return message(read_connect_response(reader));
    case ServiceCode::kConnectionStateRequest: return message(read_channel_request<ConnectionStateRequest>(reader));
    case ServiceCode::kConnectionStateResponse: return message(read_channel_response<ConnectionStateResponse>(reader));
    case ServiceCode::kDisconnectRequest: return message(read_channel_request<DisconnectRequest>(reader));
    case ServiceCode::kDisconnectResponse: return message(read_channel_response<DisconnectResponse>(reader));
    case ServiceCode::kDeviceConfigurationRequest:
    case ServiceCode::kTunnellingRequest: return message(read_connection_request(frame.service, reader));
    case ServiceCode::kDeviceConfigurationAck:
    case ServiceCode::kTunnellingAck: return message(read_connection_ack(frame.service, reader));
    case ServiceCode::kFeatureGet:
    case ServiceCode::kFeatureResponse:
    case ServiceCode::kFeatureSet:
    case ServiceCode::kFeatureNotice: return message(read_feature(frame.service, reader));
    case ServiceCode::kRoutingIndication: return Message(RoutingIndication{frame.body, false});
    case ServiceCode::kRoutingSystemBroadcast: return Message(RoutingIndication{frame.body, true});
    case ServiceCode::kRoutingLostMessage: return message(read_lost(reader));
    case ServiceCode::kRoutingBusy: return message(read_busy(reader));
    default: return Message(OtherService{frame.service, frame.body});
  }
}

void append(Bytes& out, ByteView bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

/// One overload for each body: opens the frame and writes the body.
struct BodyWriter {
  Bytes& out;

  void operator()(const OtherService& body) const {
    open_frame(out, body.service);
    append(out, body.body);
  }
  void operator()(const SearchRequest& body) const {
    open_frame(out, body.extended ? ServiceCode::kSearchRequestExtended : ServiceCode::kSearchRequest);
    write(out, body.discovery);
    for (const auto& parameter : body.parameters) write(out, parameter);
  }
  void operator()(const SearchResponse& body) const {
    open_frame(out, body.extended ? ServiceCode::kSearchResponseExtended : ServiceCode::kSearchResponse);
    write(out, body.control);
    for (const auto& dib : body.dibs) write(out, dib);
  }
  void operator()(const DescriptionRequest& body) const {
    open_frame(out, ServiceCode::kDescriptionRequest);
    write(out, body.control);
  }
  void operator()(const DescriptionResponse& body) const {
    open_frame(out, ServiceCode::kDescriptionResponse);
    for (const auto& dib : body.dibs) write(out, dib);
  }
  void operator()(const ConnectRequest& body) const {
    open_frame(out, ServiceCode::kConnectRequest);
    write(out, body.control);
    write(out, body.data);
    write(out, body.cri);
  }
  void operator()(const ConnectResponse& body) const {
    open_frame(out, ServiceCode::kConnectResponse);
    append(out, Bytes{body.channel, body.status});
    if (body.status != 0) return;
    write(out, body.data);
    write(out, body.crd);
  }
  void operator()(const ConnectionStateRequest& body) const {
    channel(ServiceCode::kConnectionStateRequest, body.channel, 0);
    write(out, body.control);
  }
  void operator()(const ConnectionStateResponse& body) const {
    channel(ServiceCode::kConnectionStateResponse, body.channel, body.status);
  }
  void operator()(const DisconnectRequest& body) const {
    channel(ServiceCode::kDisconnectRequest, body.channel, 0);
    write(out, body.control);
  }
  void operator()(const DisconnectResponse& body) const {
    channel(ServiceCode::kDisconnectResponse, body.channel, body.status);
  }
  void operator()(const ConnectionRequest& body) const {
    open_frame(out, body.service);
    write(out, body.header);
    append(out, body.cemi);
  }
  void operator()(const ConnectionAck& body) const {
    open_frame(out, body.service);
    write(out, body.header);
  }
  void operator()(const FeatureMessage& body) const {
    open_frame(out, body.service);
    write(out, body.header);
    append(out, Bytes{body.feature, body.code});
    append(out, body.value);
  }
  void operator()(const RoutingIndication& body) const {
    open_frame(out, body.system_broadcast ? ServiceCode::kRoutingSystemBroadcast : ServiceCode::kRoutingIndication);
    append(out, body.cemi);
  }
  void operator()(const RoutingLostMessage& body) const {
    open_frame(out, ServiceCode::kRoutingLostMessage);
    append(out, Bytes{4, body.device_state});
    write_u16(out, body.lost);
  }
  void operator()(const RoutingBusy& body) const {
    open_frame(out, ServiceCode::kRoutingBusy);
    append(out, Bytes{6, body.device_state});
    write_u16(out, body.wait);
    write_u16(out, body.control);
  }

 private:
  void channel(ServiceCode service, std::uint8_t channel, std::uint8_t status) const {
    open_frame(out, service);
    append(out, Bytes{channel, status});
  }
};

}  // namespace

Result<Message> read_message(const Frame& frame) {
  auto read = read_body(frame);
  if (!read) return fail(read.error().code, fmt::format("{}: {}", to_string(frame.service), read.error().text));
  return read;
}

Result<Message> read_message(ByteView bytes) {
  const auto frame = read_frame(bytes);
  if (!frame) return fail(frame.error());
  return read_message(*frame);
}

Bytes write(const Message& message) {
  Bytes out;
  std::visit(BodyWriter{out}, message);
  close_frame(out);
  return out;
}

void write_connection_request(Bytes& out, ServiceCode service, const ConnectionHeader& header, ByteView cemi) {
  out.clear();
  open_frame(out, service);
  write(out, header);
  append(out, cemi);
  close_frame(out);
}

void write_connection_ack(Bytes& out, ServiceCode service, const ConnectionHeader& header) {
  out.clear();
  open_frame(out, service);
  write(out, header);
  close_frame(out);
}

}  // namespace rubicon::networks::knx::wire
