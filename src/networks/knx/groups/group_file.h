#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "model/point.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/wire/address.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx::groups {

/// Names of scenes by their number, from 1 to 64 as ETS and panels show it (0 to 63 on the wire: KNX 3/7/2, DPT 17).
using SceneNames = std::map<std::uint8_t, std::string>;

/// The catalogue's type of a point whose scenes have names: an enumeration with the words of the point.
inline constexpr TypeId kNamedScene{0x0280};
inline constexpr std::uint8_t kMaxScenes = 64;
/// Added to the number of a scene: it is stored, not recalled. Bit 7 of 18.001 on the wire.
inline constexpr std::uint32_t kStores = 128;

/// True for 17.001 (recall) and 18.001 (recall and store).
bool has_scenes(dpt::DptId type);
/// What is wrong with the name of a scene; empty if it can be one: it must differ from numbers and from `store ...`.
std::string_view scene_name_fault(std::string_view name);

/// The words of a point: `evening` (1), and for 18.001 `store evening` (129) and `store 5` (133) for those without a
/// name. Sorted by value.
std::vector<model::Word> scene_words(dpt::DptId type, const SceneNames& names);
/// The highest number: 64, with 18.001 192 (128 + 64: the last one is stored).
std::uint32_t most_scene_number(dpt::DptId type);

/// The word of a payload of one byte, else its number.
Value scene_value(dpt::DptId type, const std::vector<model::Word>& words, std::uint8_t byte);
/// The payload of a word or number. kInvalid, kOutOfRange.
Result<wire::Payload> scene_payload(dpt::DptId type, const std::vector<model::Word>& words, const Value& value);

/// When the value of a point is read from the bus (knx.md, section 8).
struct ReadRule {
  enum class When : std::uint8_t { kDemand, kInit, kExpire, kEvery, kNever };
  When when = When::kDemand;  ///< kDemand: for the first subscriber and after a reconnect
  Duration period{};          ///< of expire and every
  friend bool operator==(const ReadRule&, const ReadRule&) = default;
};

/// One sensor or actuator, with one or two group addresses.
struct GroupPoint {
  wire::GroupAddress address{};  ///< receives the commands of an actuator, reports the values of a sensor
  std::optional<wire::GroupAddress>
      state{};                               ///< reports the state of an actuator; without one its commands end assumed
  std::vector<wire::GroupAddress> listen{};  ///< further addresses that report its value
  std::optional<dpt::DptId> dpt{};           ///< nullopt: values are bytes in hex
  Kind kind = Kind::kSensor;
  std::string device{};               ///< id of its device; empty = a device of its own, named after the address
  std::string device_name{};          ///< for display
  std::string instance = "1";         ///< follows the type in keys: `switch-1`, `switch-ceiling`
  std::string name{}, description{};  ///< for display
  std::string state_name{};           ///< of its state address, for display
  std::string main_group{}, middle_group{};
  std::string room{};  ///< `First floor / Kitchen`
  ReadRule read{};
  std::optional<SceneNames> scenes{};  ///< of 17.001 and 18.001: values are names and numbers from 1

  friend bool operator==(const GroupPoint&, const GroupPoint&) = default;
};

/// Reads a group file, the part of a network's configuration that describes group addresses, written by `rubicon knx
/// import` or by hand (docs/knx-import.md): `groups` and `group-names` of `reader`. Appends to `out` in the order of
/// the file. Points with an error (address or type, duplicate address, one state address of two actuators, two points
/// with one key) are reported at their place and left out.
void read_groups(ConfigReader& reader, std::vector<GroupPoint>& out);

/// `notation` of a group file or of a network: how texts for people show group addresses; nullopt if it is absent.
std::optional<wire::Notation> read_notation(ConfigReader& reader);

/// The conflicts between points of several sources, one line each: one address of two points, one state address of two
/// actuators, one key of two points. read_groups() reports those within one file.
std::vector<std::string> conflicts(const std::vector<GroupPoint>& points);

/// `demand`, `init`, `never`, `expire 60min`, `every 5min`.
std::optional<ReadRule> parse_read_rule(std::string_view text);
std::string to_string(const ReadRule& rule);

/// The group file as YAML: sorted by address, one line per point; equal points give equal text. `source` is named in a
/// comment. `secured`: the groups that take secured telegrams only. Addresses are written in `notation`.
std::string to_yaml(const std::vector<GroupPoint>& points, const std::string& source,
                    const std::vector<wire::GroupAddress>& secured = {},
                    wire::Notation notation = wire::Notation::kThreeLevel);

/// Merges a newer import into the points of a group file, sorted by address. Known points keep device, instance, kind,
/// type, read rule and state address; the import sets their name, description and groups. New are addresses that the
/// group file does not have, and state addresses of actuators without one. Addresses that the import does not have are
/// kept. The report lists all differences.
std::vector<GroupPoint> merge(std::vector<GroupPoint> known, const std::vector<GroupPoint>& imported, Report& report);

}  // namespace rubicon::networks::knx::groups
