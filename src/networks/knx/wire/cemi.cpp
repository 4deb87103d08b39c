#include "networks/knx/wire/cemi.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
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

namespace {

struct Named {
  std::uint16_t first, last;
  std::string_view name;
};

/// Message codes (KNX 3/6/3).
constexpr std::array kCodes{
    Named{0x10, 0x10, "L_Raw.req"},
    Named{0x11, 0x11, "L_Data.req"},
    Named{0x13, 0x13, "L_Poll_Data.req"},
    Named{0x25, 0x25, "L_Poll_Data.con"},
    Named{0x29, 0x29, "L_Data.ind"},
    Named{0x2b, 0x2b, "L_Busmon.ind"},
    Named{0x2d, 0x2d, "L_Raw.ind"},
    Named{0x2e, 0x2e, "L_Data.con"},
    Named{0x2f, 0x2f, "L_Raw.con"},
    Named{0xf0, 0xf0, "M_Reset.ind"},
    Named{0xf1, 0xf1, "M_Reset.req"},
    Named{0xf5, 0xf5, "M_PropWrite.con"},
    Named{0xf6, 0xf6, "M_PropWrite.req"},
    Named{0xf7, 0xf7, "M_PropInfo.ind"},
    Named{0xf8, 0xf8, "M_FuncPropCommand.req"},
    Named{0xf9, 0xf9, "M_FuncPropStateRead.req"},
    Named{0xfa, 0xfa, "M_FuncProp.con"},
    Named{0xfb, 0xfb, "M_PropRead.con"},
    Named{0xfc, 0xfc, "M_PropRead.req"},
};

/// Ranges of APCIs (KNX 3/3/7). In the wider ones the low six bits are data.
constexpr std::array kServices{
    Named{0x000, 0x03f, "GroupValueRead"},
    Named{0x040, 0x07f, "GroupValueResponse"},
    Named{0x080, 0x0bf, "GroupValueWrite"},
    Named{0x0c0, 0x0c0, "IndividualAddressWrite"},
    Named{0x100, 0x100, "IndividualAddressRead"},
    Named{0x140, 0x140, "IndividualAddressResponse"},
    Named{0x180, 0x1bf, "AdcRead"},
    Named{0x1c8, 0x1c8, "SystemNetworkParameterRead"},
    Named{0x1c9, 0x1c9, "SystemNetworkParameterResponse"},
    Named{0x1ca, 0x1ca, "SystemNetworkParameterWrite"},
    Named{0x1cc, 0x1d6, "PropertyExt"},
    Named{0x1fb, 0x1fe, "MemoryExtended"},
    Named{0x1c0, 0x1ff, "AdcResponse"},
    Named{0x200, 0x23f, "MemoryRead"},
    Named{0x240, 0x27f, "MemoryResponse"},
    Named{0x280, 0x2bf, "MemoryWrite"},
    Named{0x2c0, 0x2c4, "UserMemory"},
    Named{0x2c5, 0x2c6, "UserManufacturer"},
    Named{0x2c7, 0x2c9, "FunctionProperty"},
    Named{0x300, 0x33f, "DeviceDescriptorRead"},
    Named{0x340, 0x37f, "DeviceDescriptorResponse"},
    Named{0x380, 0x3bf, "Restart"},
    Named{0x3c0, 0x3cf, "RouterMemory"},
    Named{0x3d1, 0x3d1, "AuthorizeRequest"},
    Named{0x3d2, 0x3d2, "AuthorizeResponse"},
    Named{0x3d3, 0x3d3, "KeyWrite"},
    Named{0x3d4, 0x3d4, "KeyResponse"},
    Named{0x3d5, 0x3d5, "PropertyValueRead"},
    Named{0x3d6, 0x3d6, "PropertyValueResponse"},
    Named{0x3d7, 0x3d7, "PropertyValueWrite"},
    Named{0x3d8, 0x3d8, "PropertyDescriptionRead"},
    Named{0x3d9, 0x3d9, "PropertyDescriptionResponse"},
    Named{0x3da, 0x3da, "NetworkParameterRead"},
    Named{0x3db, 0x3db, "NetworkParameterResponse"},
    Named{0x3dc, 0x3dc, "IndividualAddressSerialRead"},
    Named{0x3dd, 0x3dd, "IndividualAddressSerialResponse"},
    Named{0x3de, 0x3de, "IndividualAddressSerialWrite"},
    Named{0x3e0, 0x3e3, "DomainAddress"},
    Named{0x3e4, 0x3e4, "NetworkParameterWrite"},
    Named{0x3e5, 0x3e7, "Link"},
    Named{0x3e8, 0x3eb, "GroupPropertyValue"},
    Named{0x3ec, 0x3ee, "DomainAddressSerial"},
    Named{0x3f0, 0x3f0, "FileStream"},
    Named{0x3f1, 0x3f1, "SecureService"},
};

template <std::size_t kSize>
std::string name_in(const std::array<Named, kSize>& names, unsigned code, std::string_view prefix) {
  const auto found = std::find_if(names.begin(), names.end(),
                                  [code](const Named& named) { return code >= named.first && code <= named.last; });
  return found == names.end() ? fmt::format("{} {:02X}", prefix, code) : std::string(found->name);
}

/// ` 0C 33`.
std::string hex(ByteView bytes) {
  std::string text;
  for (const auto byte : bytes) base::append(text, " {:02X}", byte);
  return text;
}

std::string_view name_of(Priority priority) {
  constexpr std::array<std::string_view, 4> kNames{"system", "normal", "urgent", "low"};
  return kNames[static_cast<std::size_t>(priority) & 3];
}

/// The text of a TPCI without an APCI (connections and their acknowledgements); empty for data.
std::string control_text(std::uint8_t tpci) {
  switch (tpci & 0xc3) {
    case 0x80: return "Connect";
    case 0x81: return "Disconnect";
    case 0xc2: return fmt::format("Ack {}", tpci >> 2 & 0xf);
    case 0xc3: return fmt::format("Nak {}", tpci >> 2 & 0xf);
    default: return (tpci & 0x80) != 0 ? fmt::format("TPCI {:02X}", tpci) : std::string();
  }
}

std::string tpdu_text(ByteView tpdu) {
  if (auto control = control_text(tpdu[0]); !control.empty()) return control;
  const auto numbered = (tpdu[0] & 0x40) != 0 ? fmt::format("#{} ", tpdu[0] >> 2 & 0xf) : std::string();
  if (tpdu.size() < 2) return fmt::format("{}TPCI {:02X}", numbered, tpdu[0]);
  const unsigned apci = (tpdu[0] & 3U) << 8 | tpdu[1];
  const auto text = numbered + name_in(kServices, apci, "APCI");
  const bool group_value = apci >= 0x40 && apci < 0xc0;
  if (group_value && tpdu.size() == 2) return fmt::format("{} (small) {:02X}", text, apci & 0x3f);
  return text + hex(tpdu.subspan(2));
}

std::string data_text(const DataFrame& frame, Notation notation) {
  const auto to = !frame.to_group()        ? to_string(IndividualAddress(frame.destination))
                  : frame.destination == 0 ? std::string("broadcast")
                                           : to_string(GroupAddress(frame.destination), notation);
  std::string flags;
  if (frame.repeated() && frame.code == CemiCode::kDataIndication) flags += "repeated ";
  if (frame.failed() && frame.code == CemiCode::kDataConfirmation) flags += "not acknowledged ";
  if (frame.lte()) return fmt::format("{}LTE from {}{}", flags, to_string(frame.source), hex(frame.tpdu));
  return fmt::format("{} {}from {} to {} hops {} {}", name_of(frame.priority()), flags, to_string(frame.source), to,
                     frame.hops(), tpdu_text(frame.tpdu));
}

}  // namespace

std::string describe(ByteView cemi, Notation notation) {
  if (cemi.empty()) return "empty frame";
  const auto name = name_in(kCodes, cemi[0], "cEMI");
  const auto frame = read_data_frame(cemi);
  if (frame) return fmt::format("{} {}", name, data_text(*frame, notation));
  const auto why = frame.error().code == ErrorCode::kUnsupported ? std::string() : " (" + frame.error().text + ")";
  return name + hex(cemi.subspan(1)) + why;
}

}  // namespace rubicon::networks::knx::wire
