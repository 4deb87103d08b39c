#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "motes/mote_packet.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::wsn {

/// The type tag of application messages to and from motes (docs/motes.md), one of
/// `mote/<transport>/<application>/<record type>`: a radio message; the record type is the first byte of the record,
/// `.../reliable`: the mote acknowledges it, `.../reliable/<sequence>`: with the sender's own sequence number,
/// `mote/am/<AM type>`: another packet for the sink itself (wsn.md 6), without the AM header,
/// `mote/json`, `mote/json/reliable`: a command of the learning or synaptic layer, as JSON.
struct MoteTag {
  enum class Kind : std::uint8_t { kNet, kAm, kJson };
  Kind kind = Kind::kNet;
  std::uint8_t transport = 0, application = 0, type = 0;  ///< kAm: only the type
  bool reliable = false;
  std::optional<std::uint16_t> sequence;

  friend bool operator==(const MoteTag&, const MoteTag&) = default;
};

/// kUnsupported if the tag does not begin with `mote/`, kInvalid if the rest is malformed.
Result<MoteTag> parse_tag(std::string_view text);

/// The address of a mote, 1 to 65532, from a device name: `7`. nullopt for everything else.
std::optional<std::uint16_t> mote_address(std::string_view device);
/// The same for the receiver of a message, where no device means all motes. A member that may send to all motes except
/// some may not send to 65535: this radio address means all motes and is not a device.
std::optional<std::uint16_t> receiver_address(std::string_view device);

/// The application's part of a radio message to a mote.
struct LearningMessage {
  std::uint8_t transport = 0;
  std::uint8_t application = 0;
  Bytes record;

  friend bool operator==(const LearningMessage&, const LearningMessage&) = default;
};

/// Parses a message such as `{"record": "NetIdCmd", "command": 1, "netId": 300, "seq": 48879}`; fields as in
/// motes/learning_records.h. Learning records have transport 3 and application 6, synaptic ones 1 and 11; the members
/// `transport` and `application` (1 to 255) override this, and are required where none is known. The error names the
/// member and what was expected.
Result<LearningMessage> learning_message(std::string_view json);

/// The same form for a message that a mote or a computer sent, without padding; nullopt if its record is of another
/// kind or cut short. NaN and infinity become null.
std::optional<std::string> learning_json(const motes::NetMessage& message);

}  // namespace rubicon::networks::wsn
