#include "networks/knx/wire/cemi.h"

#include <fmt/format.h>

#include <algorithm>

#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/frame.h"

namespace rubicon::networks::knx::wire {

namespace {

/// After the additional info: Ctrl1, Ctrl2, source, destination, NPDU length.
constexpr std::size_t kFixed = 7;
constexpr std::uint8_t kEscape = 255;
constexpr std::uint8_t kNotExtended = 0x80, kDoNotRepeat = 0x20, kBroadcast = 0x10, kGroup = 0x80;
constexpr std::uint8_t kSmallMask = 0x3f;

bool is_data(std::uint8_t code) {
  return code == static_cast<std::uint8_t>(CemiCode::kDataRequest) ||
         code == static_cast<std::uint8_t>(CemiCode::kDataIndication) ||
         code == static_cast<std::uint8_t>(CemiCode::kDataConfirmation);
}

/// From Ctrl1 on; empty if the frame is too short for the fixed part.
ByteView behind_info(ByteView cemi) {
  if (cemi.size() < 2) return {};
  const std::size_t start = 2U + cemi[1];
  return cemi.size() < start + kFixed ? ByteView{} : cemi.subspan(start);
}

/// The low two bits of the TPCI byte and the next byte.
std::uint16_t apci_of(ByteView tpdu) {
  return static_cast<std::uint16_t>((tpdu[0] & 3) << 8 | tpdu[1]);
}

Result<void> can_be_sent(const Telegram& telegram) {
  const auto& bytes = telegram.payload.bytes;
  if (number(telegram.destination) == 0)
    return fail(ErrorCode::kInvalid, "telegram: 0/0/0 is the broadcast address, expected a group address");
  if (telegram.hops > 7)
    return fail(ErrorCode::kOutOfRange, fmt::format("telegram: hop count {}, expected 0 to 7", telegram.hops));
  if (telegram.service == Service::kRead) {
    if (bytes.empty()) return {};
    return fail(ErrorCode::kInvalid, "telegram: a read carries no payload");
  }
  if (telegram.payload.small && (bytes.size() != 1 || bytes[0] > kSmallMask))
    return fail(ErrorCode::kInvalid, "telegram: a small payload is one byte of 0 to 63");
  if (bytes.empty() || bytes.size() > kMaxPayload)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("telegram: payload of {} bytes, expected 1 to {}", bytes.size(), kMaxPayload));
  return {};
}

std::uint8_t apci_low(const Telegram& telegram) {
  const auto code = static_cast<unsigned>(telegram.service) << 6;
  const bool inside = telegram.payload.small && telegram.service != Service::kRead;
  return static_cast<std::uint8_t>(code | (inside ? telegram.payload.bytes[0] : 0U));
}

}  // namespace

Result<DataFrame> read_data_frame(ByteView cemi) {
  if (cemi.empty()) return fail(ErrorCode::kInvalid, "cEMI: empty");
  if (!is_data(cemi[0])) return fail(ErrorCode::kUnsupported, fmt::format("cEMI: code {:02x} is no L_Data", cemi[0]));
  const auto rest = behind_info(cemi);
  if (rest.empty()) return fail(ErrorCode::kInvalid, fmt::format("cEMI: {} bytes are too few for L_Data", cemi.size()));
  const auto length = rest[6];
  if (length == kEscape) return fail(ErrorCode::kInvalid, "cEMI: NPDU length 255 is not used");
  const auto tpdu = rest.subspan(kFixed);
  if (tpdu.size() != length + std::size_t{1})
    return fail(ErrorCode::kInvalid,
                fmt::format("cEMI: NPDU length {}, but {} bytes follow the TPCI", length,
                            tpdu.empty() ? std::string("not even 0") : std::to_string(tpdu.size() - 1)));
  return DataFrame{CemiCode(cemi[0]), rest[0], rest[1], IndividualAddress(u16_at(rest, 2)), u16_at(rest, 4), tpdu};
}

Bytes write(const DataFrame& frame) {
  Bytes out{static_cast<std::uint8_t>(frame.code), 0, frame.control1, frame.control2};
  write_u16(out, number(frame.source));
  write_u16(out, frame.destination);
  out.push_back(static_cast<std::uint8_t>(frame.tpdu.size() - 1));
  out.insert(out.end(), frame.tpdu.begin(), frame.tpdu.end());
  return out;
}

Result<Telegram> to_telegram(const DataFrame& frame) {
  if (frame.lte()) return fail(ErrorCode::kUnsupported, "cEMI: LTE addressing");
  if (!frame.to_group() || frame.destination == 0) return fail(ErrorCode::kUnsupported, "cEMI: not for a group");
  const auto tpdu = frame.tpdu;
  if ((tpdu[0] & 0xfc) != 0 || tpdu.size() < 2)
    return fail(ErrorCode::kUnsupported, fmt::format("cEMI: TPCI {:02x} is no group data", tpdu[0]));
  const auto apci = apci_of(tpdu);
  if (apci >= 0xc0) return fail(ErrorCode::kUnsupported, fmt::format("cEMI: APCI {:03x} is no group value", apci));
  Telegram telegram;
  telegram.service = Service(apci >> 6);
  telegram.destination = GroupAddress(frame.destination);
  telegram.source = frame.source;
  telegram.priority = frame.priority();
  telegram.hops = frame.hops();
  telegram.repeated = frame.repeated();
  if (telegram.service == Service::kRead) return telegram;
  telegram.payload.small = tpdu.size() == 2;
  if (telegram.payload.small) {
    telegram.payload.bytes = {static_cast<std::uint8_t>(apci & kSmallMask)};
  } else {
    telegram.payload.bytes.assign(tpdu.begin() + 2, tpdu.end());
  }
  return telegram;
}

Result<Telegram> read_telegram(ByteView cemi) {
  const auto frame = read_data_frame(cemi);
  if (!frame) return fail(frame.error());
  return to_telegram(*frame);
}

Result<Bytes> write_telegram(CemiCode code, const Telegram& telegram) {
  if (auto right = can_be_sent(telegram); !right) return fail(right.error());
  const auto& payload = telegram.payload;
  const std::size_t behind = payload.small ? 0 : payload.bytes.size();
  const std::size_t length = 1 + behind;
  unsigned control1 = kBroadcast | static_cast<unsigned>(telegram.priority) << 2;
  if (length <= 15) control1 |= kNotExtended;
  if (!telegram.repeated) control1 |= kDoNotRepeat;
  Bytes out;
  out.reserve(11 + behind);
  out = {static_cast<std::uint8_t>(code), 0, static_cast<std::uint8_t>(control1),
         static_cast<std::uint8_t>(kGroup | telegram.hops << 4)};
  write_u16(out, number(telegram.source));
  write_u16(out, number(telegram.destination));
  out.push_back(static_cast<std::uint8_t>(length));
  out.push_back(0);
  out.push_back(apci_low(telegram));
  if (!payload.small) out.insert(out.end(), payload.bytes.begin(), payload.bytes.end());
  return out;
}

bool confirms(ByteView confirmation, ByteView request) {
  if (confirmation.empty() || confirmation[0] != static_cast<std::uint8_t>(CemiCode::kDataConfirmation)) return false;
  const auto con = behind_info(confirmation), req = behind_info(request);
  if (con.empty() || con.size() != req.size()) return false;
  const unsigned con_hops = con[1] >> 4 & 7, req_hops = req[1] >> 4 & 7;
  if ((con[1] & 0x8f) != (req[1] & 0x8f) || (con_hops != req_hops && con_hops + 1 != req_hops)) return false;
  const bool any_source = req[2] == 0 && req[3] == 0;
  const std::size_t from = any_source ? 4 : 2;
  return std::equal(con.begin() + static_cast<std::ptrdiff_t>(from), con.end(),
                    req.begin() + static_cast<std::ptrdiff_t>(from));
}

std::uint8_t control1_of(ByteView cemi) {
  const auto rest = behind_info(cemi);
  return rest.empty() ? std::uint8_t{0} : rest[0];
}

}  // namespace rubicon::networks::knx::wire
