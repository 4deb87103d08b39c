#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace rubicon::support {

struct ZipEntry {
  std::string name, content;
};

enum class ZipProtection : std::uint8_t { kNone, kZipCrypto, kAes };

/// A zip archive as libzip writes it.
std::string zip_of(const std::vector<ZipEntry>& entries, ZipProtection protection = ZipProtection::kNone,
                   const std::string& password = "");

/// A communication object, as the application program of its device states it.
struct KnxObject {
  unsigned number = 0;
  std::string text, function;
  std::string flags = "CW";  ///< C communication, R read, W write, T transmit, U update
  std::string type{};        ///< `DPST-1-1`; empty: only the size
  std::string size = "1 Bit";
  std::vector<unsigned> groups{};  ///< places in KnxHouse::groups, from 1; it sends to the first
  std::string channel{};
  std::string instance{};  ///< further attributes in the device: `DatapointType="DPT-9" ReadFlag="Enabled"`
  bool in_module = false;
  std::string parameter{};  ///< its value in the device, for the place {{0:...}} of the text
};

struct KnxDevice {
  std::string address;  ///< `1.1.5`; `1.1.` = without an address
  std::string name, room{};
  std::vector<KnxObject> objects{};
  bool in_board = false;  ///< it is in a distribution board of its room
};

struct KnxGroup {
  std::uint16_t address = 0;
  std::string name, type{}, description{};
  std::string more{};  ///< further attributes: `Security="On" Key="..."`
};

struct KnxFunction {
  std::string name, room;
  std::vector<std::pair<unsigned, std::string>> groups;  ///< place in KnxHouse::groups from 1, role
};

/// A house with its bus, written as ETS writes it: ETS 4 has links in elements of their own and long ids (below schema
/// 20), ETS 6 segments of lines and AES.
struct KnxHouse {
  unsigned schema = 20;
  std::string style = "ThreeLevel", name = "House";
  std::vector<KnxGroup> groups{};
  std::vector<KnxDevice> devices{};
  std::vector<KnxFunction> functions{};
  std::string password{};        ///< empty = not protected
  std::string program_filler{};  ///< before what is needed of each program

  std::string installation_xml() const;
  std::string project_xml() const;
  /// What the archive has, unprotected.
  std::vector<ZipEntry> entries() const;
  /// The .knxproj; with the password in the archive's way if there is one.
  std::string file() const;
};

/// Lamps, a dimmer, a blind, a thermometer and a heating controller with a module, in three rooms.
KnxHouse small_house(unsigned schema);

/// So many addresses, with an actuator for each 16 and sensors between, in 50 rooms. Each program has so many bytes
/// more.
KnxHouse large_house(unsigned schema, unsigned addresses, std::size_t program_filler = 0);

}  // namespace rubicon::support
