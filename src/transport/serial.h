#pragma once

#include <string>

namespace rubicon::transport {

/// A serial line: 8 data bits, 1 stop bit, no parity, no flow control. Modem lines are not used, so that a
/// pseudo-terminal works too.
struct SerialOptions {
  std::string path;        ///< `/dev/ttyUSB0`, `/dev/serial/by-id/...`
  unsigned baud = 115200;  ///< a rate of termios: 50 to 4000000
};

/// Whether termios has the rate.
bool is_baud_rate(unsigned baud);

}  // namespace rubicon::transport
