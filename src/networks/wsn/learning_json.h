#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "motes/mote_packet.h"

namespace rubicon::networks::wsn {

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
