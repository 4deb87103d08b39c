#include "networks/knx/wire/describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/append.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::wire {

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
