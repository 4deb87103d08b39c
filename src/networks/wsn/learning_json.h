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

/// A message as scripts write it: `{"record": "NetIdCmd", "command": 1, "netId": 300, "seq": 48879}`, the fields as in
/// motes/learning_records.h. Records of learning go to transport 3, application 6, those of the synaptic channels to 1
/// and 11; `transport` and `application` (1 to 255) say otherwise, and must be given where neither is known. The error
/// says which member is wrong and what was expected.
Result<LearningMessage> learning_message(std::string_view json);

/// The same form of a message that a mote or a computer sent, without padding; nullopt if its record is none of those
/// or is cut short. A number that is none (NaN, infinity) is null.
std::optional<std::string> learning_json(const motes::NetMessage& message);

}  // namespace rubicon::networks::wsn
