#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

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
/// The same for the receiver of a message, where no device means all motes. Who may send to each mote but some may not
/// send to all: 65535, their address on the radio, is no device.
std::optional<std::uint16_t> receiver_address(std::string_view device);

}  // namespace rubicon::networks::wsn
