#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/point.h"
#include "rubicon/address.hpp"
#include "rubicon/point.hpp"

namespace rubicon::model {

/// How far a published value can be trusted; one enum everywhere (ARCHITECTURE, section 5). Ordered, worst first.
enum class Quality : std::uint8_t { kNetworkDown, kDeviceOffline, kBad, kUnknown, kStale, kStored, kAssumed, kGood };

std::string_view to_string(Quality quality);
/// nullopt for every other word.
std::optional<Quality> parse_quality(std::string_view word);

}  // namespace rubicon::model

namespace rubicon {

using model::Quality;

}  // namespace rubicon

namespace rubicon::model {

// The JSON of the `.status` and `.description` tuples of points, devices and networks (docs/tuple-keys.md), written and
// parsed here and nowhere else. Times are seconds since 1970 UTC, zero = never. What a text does not say, or says in
// another kind of JSON, reads as empty or zero; members that are not known are ignored.

/// A commander of a point and one of its requests.
struct Commander {
  OwnerId creator{};
  std::string name;
  std::uint64_t request = 0;

  friend bool operator==(const Commander&, const Commander&) = default;
};

/// The last command of a point: member `command` of its status.
struct CommandStatus {
  std::string state;  ///< docs/life-of-a-command.md
  Commander commander;
  std::string value;
  WallTime since{};
  WallTime until{};  ///< when the state ends at the latest; zero = it is final
  std::string reason;
  std::optional<Commander> by;  ///< who superseded it

  friend bool operator==(const CommandStatus&, const CommandStatus&) = default;
};
std::string command_status_to_json(const CommandStatus& command);
/// The last command of the point whose status the text is; nullopt where the text names none.
std::optional<CommandStatus> command_status_from_json(std::string_view point_status);

/// How a command ended that the status shows no more, because a newer one came: member `ended` of the status.
struct CommandOutcome {
  OwnerId creator{};
  std::uint64_t request = 0;
  std::string state, reason;

  friend bool operator==(const CommandOutcome&, const CommandOutcome&) = default;
};
std::string command_outcomes_to_json(std::span<const CommandOutcome> outcomes);
/// Of one command; nullopt where the text does not name it.
std::optional<CommandOutcome> command_outcome_from_json(std::string_view point_status, OwnerId creator,
                                                        std::uint64_t request);

/// The status of a point on its way out, in pieces that need no copy: it is written with each reading.
struct PointStatusPieces {
  std::string_view quality, reason;
  WallTime since{}, heard{}, changed{};
  std::string_view command;  ///< what command_status_to_json() wrote; empty = there was none
  std::string_view ended{};  ///< what command_outcomes_to_json() wrote; empty = there are none
};
/// Replaces `out`, which keeps its memory.
void write_point_status(const PointStatusPieces& status, std::string& out);
PointStatus point_status_from_json(std::string_view text);

/// The first members of a point's status.
struct HeardQuality {
  Quality quality = Quality::kUnknown;
  WallTime heard{};  ///< when the last good value came; zero = never
};
/// One of them alone, as heard_quality_from_json().
std::optional<Quality> quality_from_json(std::string_view text);
/// They alone, found without parsing the rest (a recording holds a status for each reading) in a text that
/// write_point_status() wrote; nullopt where the quality is none of ours.
std::optional<HeardQuality> heard_quality_from_json(std::string_view text);

/// What a point is: its `.description`.
struct PointDescription {
  std::string type{};
  std::uint64_t type_id = 0;
  std::string quantity{}, unit{}, data_type{};
  std::optional<double> minimum{}, maximum{};
  std::vector<Word> words{};
  std::string access{};  ///< to_string(Access)
  std::string report{};  ///< state or event
  std::string instance{};

  friend bool operator==(const PointDescription&, const PointDescription&) = default;
};
/// With the numbers of the words, unless they are 0, 1, 2 and so on.
std::string point_description_to_json(const PointDescription& description);
/// nullopt for what is no JSON object. Words whose numbers are no whole numbers are left out, all of them.
std::optional<PointDescription> point_description_from_json(std::string_view text);

std::string device_condition_to_json(const DeviceCondition& condition);
DeviceCondition device_condition_from_json(std::string_view text);
/// Whether the status of a device, as device_condition_to_json() wrote it, is reachable. Does not parse the rest.
bool says_reachable(std::string_view device_status);

/// What a device is: its `.description`.
struct DeviceDescription {
  std::string name, area, model, type, address, network;
  std::vector<std::string> capabilities;  ///< the types of its points, each once
  std::vector<std::string> sensors, actuators, properties;

  friend bool operator==(const DeviceDescription&, const DeviceDescription&) = default;
};
/// Without `area` where it is empty.
std::string device_description_to_json(const DeviceDescription& description);
/// nullopt for what is no JSON object.
std::optional<DeviceDescription> device_description_from_json(std::string_view text);

std::string line_status_to_json(const LineStatus& status);
LineStatus line_status_from_json(std::string_view text);

}  // namespace rubicon::model
