#include "networks/knx/secure/frames.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"

namespace rubicon::networks::knx::secure {

namespace {

using base::ByteReader;
using wire::ServiceCode;

constexpr std::size_t kRequestSize = 40, kResponseSize = 50, kRefusalSize = 2, kAuthenticateSize = 18, kStatusSize = 2,
                      kNotifySize = 30;
/// Of the body of a wrapper: session, sequence, serial and tag; then the content; then the MAC.
constexpr std::size_t kWrapperHeadSize = 16, kWrapperMacSize = 16;

Result<void> of_size(const wire::Frame& frame, std::size_t size) {
  if (frame.body.size() == size) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: body of {} bytes, expected {}", to_string(frame.service), frame.body.size(), size));
}

template <std::size_t size>
std::array<std::uint8_t, size> take(ByteReader& reader) {
  std::array<std::uint8_t, size> out{};
  const auto bytes = reader.take(size);
  std::copy(bytes.begin(), bytes.end(), out.begin());
  return out;
}

std::uint64_t take_48(ByteReader& reader) {
  const std::uint64_t high = reader.u16_be();
  return high << 32U | reader.u32_be();
}

void append(Bytes& out, ByteView bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void append_48(Bytes& out, std::uint64_t value) {
  for (const auto shift : {40U, 32U, 24U, 16U, 8U, 0U})
    out.push_back(static_cast<std::uint8_t>(value >> shift & 0xffU));
}

bool forbidden(ServiceCode service) {
  const auto code = static_cast<unsigned>(service);
  return service == ServiceCode::kSecureWrapper || (code >= 0x0740 && code <= 0x0743);
}

}  // namespace

Result<SessionRequest> read_session_request(const wire::Frame& frame) {
  if (auto right = of_size(frame, kRequestSize); !right) return fail(right.error());
  ByteReader reader(frame.body);
  const auto control = wire::read_hpai(reader);
  if (!control) return fail(control.error());
  return SessionRequest{*control, take<32>(reader)};
}

Bytes write(const SessionRequest& request) {
  Bytes out;
  wire::open_frame(out, ServiceCode::kSessionRequest);
  wire::write(out, request.control);
  append(out, request.public_key);
  wire::close_frame(out);
  return out;
}

Result<SessionResponse> read_session_response(const wire::Frame& frame) {
  ByteReader reader(frame.body);
  if (frame.body.size() == kRefusalSize && wire::u16_at(frame.body, 0) == 0) return SessionResponse{};
  if (auto right = of_size(frame, kResponseSize); !right) return fail(right.error());
  SessionResponse response;
  response.session = reader.u16_be();
  response.public_key = take<32>(reader);
  response.mac = take<kWrapperMacSize>(reader);
  return response;
}

Bytes write(const SessionResponse& response) {
  Bytes out;
  wire::open_frame(out, ServiceCode::kSessionResponse);
  wire::write_u16(out, response.session);
  append(out, response.public_key);
  append(out, response.mac);
  wire::close_frame(out);
  return out;
}

Result<SessionAuthenticate> read_session_authenticate(const wire::Frame& frame) {
  if (auto right = of_size(frame, kAuthenticateSize); !right) return fail(right.error());
  ByteReader reader(frame.body);
  reader.skip(1);
  SessionAuthenticate authenticate;
  authenticate.user = reader.u8();
  authenticate.mac = take<kWrapperMacSize>(reader);
  return authenticate;
}

Bytes write(const SessionAuthenticate& authenticate) {
  Bytes out;
  wire::open_frame(out, ServiceCode::kSessionAuthenticate);
  append(out, Bytes{0, authenticate.user});
  append(out, authenticate.mac);
  wire::close_frame(out);
  return out;
}

Result<Status> read_session_status(const wire::Frame& frame) {
  if (auto right = of_size(frame, kStatusSize); !right) return fail(right.error());
  return Status(frame.body[0]);
}

Bytes write(Status status) {
  Bytes out;
  wire::open_frame(out, ServiceCode::kSessionStatus);
  append(out, Bytes{static_cast<std::uint8_t>(status), 0});
  wire::close_frame(out);
  return out;
}

Result<TimerNotify> read_timer_notify(const wire::Frame& frame) {
  if (auto right = of_size(frame, kNotifySize); !right) return fail(right.error());
  ByteReader reader(frame.body);
  TimerNotify notify;
  notify.timer = take_48(reader);
  notify.serial = take<6>(reader);
  notify.tag = reader.u16_be();
  notify.mac = take<kWrapperMacSize>(reader);
  return notify;
}

Bytes write(const TimerNotify& notify) {
  Bytes out;
  wire::open_frame(out, ServiceCode::kTimerNotify);
  append_48(out, notify.timer);
  append(out, notify.serial);
  wire::write_u16(out, notify.tag);
  append(out, notify.mac);
  wire::close_frame(out);
  return out;
}

// Wrappers.

Result<Wrapper> read_wrapper(const wire::Frame& frame) {
  if (frame.body.size() < kWrapperHeadSize + kWrapperMacSize)
    return fail(ErrorCode::kInvalid, fmt::format("{}: body of {} bytes, expected at least {}", to_string(frame.service),
                                                 frame.body.size(), kWrapperHeadSize + kWrapperMacSize));
  ByteReader reader(frame.body);
  Wrapper wrapper;
  wrapper.head.session = reader.u16_be();
  wrapper.head.sequence = take_48(reader);
  wrapper.head.serial = take<6>(reader);
  wrapper.head.tag = reader.u16_be();
  wrapper.content = reader.take(reader.remaining() - kWrapperMacSize);
  wrapper.mac = reader.take(kWrapperMacSize);
  return wrapper;
}

Nonce nonce_of(const WrapperHead& head, std::size_t size) {
  Nonce nonce;
  auto& block = nonce.b0;
  for (unsigned i = 0; i < 6; ++i) block[i] = static_cast<std::uint8_t>(head.sequence >> (40 - 8 * i) & 0xffU);
  std::copy(head.serial.begin(), head.serial.end(), block.begin() + 6);
  block[12] = static_cast<std::uint8_t>(head.tag >> 8U);
  block[13] = static_cast<std::uint8_t>(head.tag & 0xffU);
  nonce.c0 = block;
  nonce.c0[14] = 0xff;
  block[14] = static_cast<std::uint8_t>(size >> 8U);
  block[15] = static_cast<std::uint8_t>(size & 0xffU);
  return nonce;
}

Result<void> seal_wrapper(Ccm& ccm, const Key& key, const WrapperHead& head, ByteView frame, Bytes& out) {
  RUBICON_ASSERT(wire::kHeaderSize + kWrapperHeadSize + frame.size() + kWrapperMacSize <= 0xffff);
  out.clear();
  wire::open_frame(out, ServiceCode::kSecureWrapper);
  wire::write_u16(out, head.session);
  append_48(out, head.sequence);
  append(out, head.serial);
  wire::write_u16(out, head.tag);
  append(out, frame);
  out.resize(out.size() + kWrapperMacSize);
  wire::close_frame(out);
  const auto all = std::span(out);
  const auto content = all.subspan(wire::kHeaderSize + kWrapperHeadSize, frame.size());
  return ccm.seal(key, nonce_of(head, frame.size()), all.first(wire::kHeaderSize + 2), content,
                  all.last(kWrapperMacSize));
}

namespace {

/// Header and session of the wrapper as transmitted.
std::array<std::uint8_t, 8> associated_of(const Wrapper& wrapper) {
  const auto total = wire::kHeaderSize + kWrapperHeadSize + wrapper.content.size() + kWrapperMacSize;
  return {0x06,
          0x10,
          0x09,
          0x50,
          static_cast<std::uint8_t>(total >> 8U),
          static_cast<std::uint8_t>(total & 0xffU),
          static_cast<std::uint8_t>(wrapper.head.session >> 8U),
          static_cast<std::uint8_t>(wrapper.head.session & 0xffU)};
}

}  // namespace

Result<Opened> open_wrapper(Ccm& ccm, const Key& key, const Wrapper& wrapper, Bytes& frame) {
  const auto associated = associated_of(wrapper);
  frame.assign(wrapper.content.begin(), wrapper.content.end());
  const auto good = ccm.open(key, nonce_of(wrapper.head, frame.size()), associated, frame, wrapper.mac);
  if (!good) return fail(good.error());
  const auto inner = *good ? wire::read_frame(frame) : Result<wire::Frame>(wire::Frame{});
  if (*good && inner && !forbidden(inner->service)) return Opened::kFrame;
  frame.clear();
  return *good ? Opened::kForbidden : Opened::kWrongMac;
}

}  // namespace rubicon::networks::knx::secure
