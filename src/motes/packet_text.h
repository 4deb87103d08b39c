#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::motes {

/// What a packet is, for people and tools that watch the traffic of a sink.
struct PacketText {
  /// join, readings, sampling, actuate, acknowledge, record (of an application), config, packet (of another AM type) or
  /// malformed.
  std::string_view kind;
  std::optional<std::uint16_t> source, destination;  ///< motes; only in radio messages
  std::string text;                                  ///< raw counts, as they stand in the packet
};
/// Never fails: a packet that cannot be decoded is malformed, and the text says why.
PacketText describe_packet(ByteView bytes);

}  // namespace rubicon::motes
