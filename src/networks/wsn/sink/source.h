#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::wsn::sink {

/// Where the packets of a sink come from, as the original spells it (wsn.md 1.3).
struct Source {
  enum class Kind : std::uint8_t {
    kSerial,     ///< `serial@DEVICE:BAUD`: a serial line or pseudo-terminal
    kStream,     ///< `network@HOST:PORT`: the bytes of a serial line over TCP
    kForwarder,  ///< `sf@HOST:PORT`: a serial forwarder, which has the sink
    kFile        ///< `file@PATH`: a packet log, played
  };
  Kind kind = Kind::kForwarder;
  std::string path;   ///< of kSerial and kFile
  unsigned baud = 0;  ///< of kSerial
  std::string host;   ///< of kStream and kForwarder
  std::uint16_t port = 0;
  std::string record;  ///< `+file@PATH` behind it: where its traffic is recorded; empty = nowhere

  friend bool operator==(const Source&, const Source&) = default;
};

/// Reads a source string; elements are joined by `+` or `>>` (wsn.md 1.3). kInvalid says what is wrong, where, and what
/// was expected; kUnsupported for `tossim-...@` and `peis@`, with what to use instead.
Result<Source> parse_source(std::string_view text);
/// The source alone, without what is behind it: `serial@/dev/ttyUSB0:115200`.
std::string to_string(const Source& source);

}  // namespace rubicon::networks::wsn::sink
