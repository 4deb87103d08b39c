#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::wsn {

/// The type tag of application messages to and from motes (docs/motes.md), one of
/// `mote/<transport>/<application>/<record type>`: a NetMsg; the record type is the first of the bytes,
/// `.../reliable`: the mote is to acknowledge it, `.../reliable/<sequence>`: with the sender's own sequence number,
/// `mote/am/<AM type>`: another packet for the sink itself (wsn.md 6), behind the AM header,
/// `mote/json`, `mote/json/reliable`: a command of the learning or synaptic layer, as JSON.
struct MoteTag {
  enum class Kind : std::uint8_t { kNet, kAm, kJson };
  Kind kind = Kind::kNet;
  std::uint8_t transport = 0, application = 0, type = 0;  ///< kAm: the type alone
  bool reliable = false;
  std::optional<std::uint16_t> sequence;

  friend bool operator==(const MoteTag&, const MoteTag&) = default;
};

/// kUnsupported for tags of others, kInvalid for what begins with `mote/` and goes on otherwise.
Result<MoteTag> parse_tag(std::string_view text);

/// A mote's address, 1 to 65532, as devices are named: `7`. With `broadcast`, 65535 too. nullopt for anything else.
std::optional<std::uint16_t> mote_address(std::string_view device, bool broadcast = false);

}  // namespace rubicon::networks::wsn
