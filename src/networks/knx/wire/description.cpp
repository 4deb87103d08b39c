#include "networks/knx/wire/description.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"
#include "base/text.h"

namespace rubicon::networks::knx::wire {

namespace {

constexpr std::size_t kNameSize = 30, kDeviceSize = 52;
/// Bits of a slot's status: usable, authorised, free; the other bits are 1.
constexpr unsigned kFree = 1, kAuthorised = 2, kUsable = 4;

std::string from_latin1(ByteView bytes) {
  std::string text;
  for (const auto byte : bytes) {
    if (byte == 0) break;
    const bool control = byte < 0x20 || (byte >= 0x7f && byte < 0xa0);
    base::append_utf8(control ? U'?' : byte, text);  // names are printed on terminals
  }
  return text;
}

/// Padded to the size of the field; characters outside ISO 8859-1, and bytes that are not UTF-8, become `?`.
Bytes to_latin1(std::string_view text) {
  Bytes bytes;
  while (!text.empty() && bytes.size() < kNameSize) {
    const auto character = base::take_utf8(text);
    bytes.push_back(character && *character <= 0xff ? static_cast<std::uint8_t>(*character) : std::uint8_t{'?'});
  }
  bytes.resize(kNameSize);
  return bytes;
}

void read_device(ByteView content, ServerDescription& into) {
  base::ByteReader reader(content);
  into.medium = reader.u8();
  into.programming_mode = (reader.u8() & 1) != 0;
  into.address = IndividualAddress(reader.u16_be());
  into.project = reader.u16_be();
  const auto serial = reader.take(6), multicast = reader.take(4), mac = reader.take(6);
  std::copy(serial.begin(), serial.end(), into.serial.begin());
  std::copy(multicast.begin(), multicast.end(), into.multicast.begin());
  std::copy(mac.begin(), mac.end(), into.mac.begin());
  into.name = from_latin1(reader.take(kNameSize));
}

std::vector<FamilyVersion> read_families(ByteView content) {
  std::vector<FamilyVersion> families;
  for (std::size_t i = 0; i + 1 < content.size(); i += 2) families.push_back({Family(content[i]), content[i + 1]});
  return families;
}

void read_tunnelling(ByteView content, ServerDescription& into) {
  base::ByteReader reader(content);
  into.max_apdu = reader.u16_be();
  into.slots.clear();
  while (reader.remaining() >= 4) {
    TunnelSlot slot{IndividualAddress(reader.u16_be())};
    const auto bits = reader.u16_be();
    slot.free = (bits & kFree) != 0;
    slot.authorised = (bits & kAuthorised) != 0;
    slot.usable = (bits & kUsable) != 0;
    into.slots.push_back(slot);
  }
}

std::vector<IndividualAddress> read_addresses(ByteView content) {
  std::vector<IndividualAddress> addresses;
  base::ByteReader reader(content);
  reader.skip(2);  // the server's own address, known from the device block
  while (reader.remaining() >= 2) addresses.push_back(IndividualAddress(reader.u16_be()));
  return addresses;
}

/// Known blocks of a wrong length are ignored.
bool has_right_length(const Dib& dib) {
  const auto size = dib.content.size();
  switch (dib.type) {
    case Dib::Type::kDevice: return size == kDeviceSize;
    case Dib::Type::kFamilies:
    case Dib::Type::kSecuredFamilies: return size % 2 == 0;
    case Dib::Type::kAddresses: return size >= 2 && size % 2 == 0;
    case Dib::Type::kTunnelling: return size >= 2 && size % 4 == 2;
    default: return false;
  }
}

void read_dib(const Dib& dib, ServerDescription& into) {
  if (!has_right_length(dib)) return;
  switch (dib.type) {
    case Dib::Type::kDevice: return read_device(dib.content, into);
    case Dib::Type::kFamilies: into.families = read_families(dib.content); return;
    case Dib::Type::kSecuredFamilies: into.secured = read_families(dib.content); return;
    case Dib::Type::kAddresses: into.addresses = read_addresses(dib.content); return;
    case Dib::Type::kTunnelling: return read_tunnelling(dib.content, into);
    default: return;
  }
}

Dib device_dib(const ServerDescription& of) {
  Dib dib{Dib::Type::kDevice, {of.medium, static_cast<std::uint8_t>(of.programming_mode ? 1 : 0)}};
  write_u16(dib.content, number(of.address));
  write_u16(dib.content, of.project);
  dib.content.insert(dib.content.end(), of.serial.begin(), of.serial.end());
  dib.content.insert(dib.content.end(), of.multicast.begin(), of.multicast.end());
  dib.content.insert(dib.content.end(), of.mac.begin(), of.mac.end());
  const auto name = to_latin1(of.name);
  dib.content.insert(dib.content.end(), name.begin(), name.end());
  return dib;
}

Dib families_dib(Dib::Type type, std::span<const FamilyVersion> families) {
  Dib dib{type, {}};
  for (const auto& [family, version] : families) {
    dib.content.push_back(static_cast<std::uint8_t>(family));
    dib.content.push_back(version);
  }
  return dib;
}

Dib tunnelling_dib(const ServerDescription& of) {
  Dib dib{Dib::Type::kTunnelling, {}};
  write_u16(dib.content, of.max_apdu.value_or(15));
  for (const auto& slot : of.slots) {
    write_u16(dib.content, number(slot.address));
    const unsigned bits =
        0xfff8U | (slot.usable ? kUsable : 0) | (slot.authorised ? kAuthorised : 0) | (slot.free ? kFree : 0);
    write_u16(dib.content, static_cast<std::uint16_t>(bits));
  }
  return dib;
}

}  // namespace

Result<std::vector<Dib>> read_dibs(base::ByteReader& reader) {
  std::vector<Dib> dibs;
  while (reader.remaining() > 0) {
    const auto length = reader.u8();
    if (length == 0) return fail(ErrorCode::kInvalid, "DIB: length 0, expected at least 2");
    if (length == 1) continue;  // no room for a type
    const auto content = reader.take(length - std::size_t{1});
    if (!reader.ok()) return fail(ErrorCode::kInvalid, "DIB: goes beyond the end of the frame");
    dibs.push_back({Dib::Type(content[0]), Bytes(content.begin() + 1, content.end())});
  }
  return dibs;
}

void write(Bytes& out, const Dib& dib) {
  RUBICON_ASSERT(dib.content.size() <= 253);
  out.push_back(static_cast<std::uint8_t>(dib.content.size() + 2));
  out.push_back(static_cast<std::uint8_t>(dib.type));
  out.insert(out.end(), dib.content.begin(), dib.content.end());
}

std::string to_string(Family family) {
  switch (family) {
    case Family::kCore: return "core";
    case Family::kDeviceManagement: return "device management";
    case Family::kTunnelling: return "tunnelling";
    case Family::kRouting: return "routing";
    case Family::kRemoteLogging: return "remote logging";
    case Family::kRemoteConfiguration: return "remote configuration";
    case Family::kObjectServer: return "object server";
    case Family::kSecurity: return "security";
  }
  return fmt::format("family {}", static_cast<unsigned>(family));
}

std::uint8_t ServerDescription::version(Family family) const {
  for (const auto& known : families) {
    if (known.family == family) return known.version;
  }
  return 0;
}

ServerDescription read_description(std::span<const Dib> dibs) {
  ServerDescription description;
  for (const auto& dib : dibs) read_dib(dib, description);
  return description;
}

std::vector<Dib> to_dibs(const ServerDescription& description) {
  std::vector<Dib> dibs{device_dib(description), families_dib(Dib::Type::kFamilies, description.families)};
  if (!description.secured.empty()) dibs.push_back(families_dib(Dib::Type::kSecuredFamilies, description.secured));
  if (!description.addresses.empty()) {
    Dib dib{Dib::Type::kAddresses, {}};
    write_u16(dib.content, number(description.address));
    for (const auto address : description.addresses) write_u16(dib.content, number(address));
    dibs.push_back(std::move(dib));
  }
  if (!description.slots.empty() || description.max_apdu) dibs.push_back(tunnelling_dib(description));
  return dibs;
}

}  // namespace rubicon::networks::knx::wire
