#pragma once

#include <termios.h>

#include <optional>

namespace rubicon::transport {

/// The constant of termios for a baud rate; nullopt if there is none (termios(3), asm-generic/termbits.h).
std::optional<speed_t> speed_of(unsigned baud);

}  // namespace rubicon::transport
