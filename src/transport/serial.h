#pragma once

#include <string>

namespace rubicon::transport {

/// A serial line: 8 data bits, 1 stop bit, no parity, no flow control; no modem lines are touched, so that
/// pseudo-terminals do too (wsn.md 1.2).
struct SerialOptions {
  std::string path;        ///< `/dev/ttyUSB0`, `/dev/serial/by-id/...`
  unsigned baud = 115200;  ///< one that the system knows (termios)
};

/// termios knows it: 50 to 4000000.
bool is_baud_rate(unsigned baud);

}  // namespace rubicon::transport
