#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::device {

/// What a state message contains besides its values.
struct Heard {
  WallTime arrival{};
  std::optional<WallTime> last_seen{};  ///< absent: Zigbee2MQTT is configured to leave it out
  /// Its last_seen is later than all before it, or it has none: the device may have sent something. Otherwise
  /// Zigbee2MQTT published by itself: an echo, a timer of its own, a repetition.
  bool later = true;
  bool copy = false;      ///< a repetition of old values, at the start of Zigbee2MQTT for example
  bool at_start = false;  ///< a copy, or a repetition of the last message, that Zigbee2MQTT publishes when it starts
  /// A copy by the time alone: no last_seen, soon after the start. Events are no copies, as Zigbee2MQTT keeps none.
  bool presumed = false;
  bool answers = false;  ///< it has a property that was asked for and not answered yet: that one is not a copy
  bool older = false;    ///< a copy from before the last message: Zigbee2MQTT lost what came since then
  bool aged = false;     ///< its last_seen is not of this moment
  /// No property differs from the message before it: a report of what was known, or of nothing.
  bool quiet = false;
};

/// The JSON value of `last_seen` in a state message, in each form that Zigbee2MQTT has (zigbee.md, section 1):
/// `"2026-11-21T00:16:49.837Z"`, the same in local time with the offset of the zone, or milliseconds since 1970.
/// nullopt for anything else and for times outside the years 1970 to 2199.
std::optional<WallTime> read_last_seen(std::string_view json);

/// One member of a state message.
struct Member {
  std::string_view key;   ///< without escapes
  std::string_view json;  ///< the text of the value as it stands in the message, without blanks around it
};

/// Reads state messages: a JSON object with any members (zigbee.md, section 5). Keeps its memory from message to
/// message.
class StateReader {
 public:
  static constexpr std::size_t kMaxPayload = std::size_t{64} * 1024, kMaxMembers = 2000;

  StateReader();
  ~StateReader();
  StateReader(const StateReader&) = delete;
  StateReader& operator=(const StateReader&) = delete;

  /// The members, in their order; valid until the next call. Values are not checked beyond their borders: who uses one
  /// parses it. kInvalid if it is no JSON object, kOutOfRange beyond the bounds.
  Result<std::span<const Member>> read(std::string_view payload);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::zigbee::device
