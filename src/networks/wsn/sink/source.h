#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::wsn::sink {

/// Where the packets of a sink come from, in the notation of the original (wsn.md 1.3).
struct Source {
  enum class Kind : std::uint8_t {
    kSerial,     ///< `serial@DEVICE:BAUD`: a serial line or pseudo-terminal
    kStream,     ///< `network@HOST:PORT`: the bytes of a serial line over TCP
    kForwarder,  ///< `sf@HOST:PORT`: a serial forwarder that owns the sink
    kFile        ///< `file@PATH`: a packet log, played back
  };
  Kind kind = Kind::kForwarder;
  std::string path;   ///< of kSerial and kFile
  unsigned baud = 0;  ///< of kSerial
  std::string host;   ///< of kStream and kForwarder
  std::uint16_t port = 0;
  std::string record;  ///< the file that `+file@PATH` names: traffic is recorded there; empty: not recorded

  friend bool operator==(const Source&, const Source&) = default;
};

/// Parses a source string; elements are joined by `+` or `>>` (wsn.md 1.3). kInvalid names the faulty part, its
/// position and what was expected; kUnsupported for `tossim-...@` and `peis@`, with the replacement to use.
Result<Source> parse_source(std::string_view text);
/// Without the file to record to: `serial@/dev/ttyUSB0:115200`.
std::string to_string(const Source& source);

}  // namespace rubicon::networks::wsn::sink
