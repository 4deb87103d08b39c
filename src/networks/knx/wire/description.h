#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "networks/knx/wire/blocks.h"

namespace rubicon::networks::knx::wire {

/// A description information block of search and description responses (KNX 3/8/2, section 7.5.4).
struct Dib {
  enum class Type : std::uint8_t {
    kDevice = 0x01,
    kFamilies = 0x02,
    kIpConfiguration = 0x03,
    kIpCurrent = 0x04,
    kAddresses = 0x05,
    kSecuredFamilies = 0x06,
    kTunnelling = 0x07,
    kDeviceAdditional = 0x08,
    kManufacturer = 0xfe
  };
  Type type = Type::kDevice;  ///< other types are kept unchanged
  Bytes content;              ///< without length and type; at most 253
  friend bool operator==(const Dib&, const Dib&) = default;
};

/// All blocks up to the end of `reader`, without those of length 1, which have no type. kInvalid: a length of 0, or
/// beyond the end.
Result<std::vector<Dib>> read_dibs(base::ByteReader& reader);
void write(Bytes& out, const Dib& dib);

/// Families of services and their versions.
enum class Family : std::uint8_t {
  kCore = 2,
  kDeviceManagement = 3,
  kTunnelling = 4,
  kRouting = 5,
  kRemoteLogging = 6,
  kRemoteConfiguration = 7,
  kObjectServer = 8,
  kSecurity = 9
};
/// `tunnelling`; `family 12`.
std::string to_string(Family family);

struct FamilyVersion {
  Family family{};
  std::uint8_t version = 0;
  friend bool operator==(const FamilyVersion&, const FamilyVersion&) = default;
};

/// A tunnel of the server, by its address.
struct TunnelSlot {
  IndividualAddress address{};
  bool usable = true, authorised = true, free = true;
  friend bool operator==(const TunnelSlot&, const TunnelSlot&) = default;
};

/// The description that a server sends of itself. Values that are not in it have their defaults.
struct ServerDescription {
  std::uint8_t medium = 0;  ///< 02 TP1, 04 PL110, 10 RF, 20 IP; 0 = unknown
  bool programming_mode = false;
  IndividualAddress address{};
  std::uint16_t project = 0;  ///< project << 4 | installation
  std::array<std::uint8_t, 6> serial{}, mac{};
  std::array<std::uint8_t, 4> multicast{};
  std::string name;  ///< UTF-8, at most 30 characters of ISO 8859-1 on the wire; control characters read as `?`
  std::vector<FamilyVersion> families;       ///< supported
  std::vector<FamilyVersion> secured;        ///< those that REQUIRE KNX IP Secure
  std::vector<IndividualAddress> addresses;  ///< additional addresses of the server (DIB 05)
  std::optional<std::uint16_t> max_apdu;     ///< bytes, from the tunnelling block
  std::vector<TunnelSlot> slots;             ///< empty = unknown
  friend bool operator==(const ServerDescription&, const ServerDescription&) = default;

  /// Version of a family; 0 = unknown.
  std::uint8_t version(Family family) const;
};

/// Blocks of unknown type, and known ones of a wrong length, are ignored.
ServerDescription read_description(std::span<const Dib> dibs);
/// Writes the device and family blocks always, the others if they have content.
std::vector<Dib> to_dibs(const ServerDescription& description);

}  // namespace rubicon::networks::knx::wire
