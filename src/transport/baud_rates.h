#pragma once

#include <termios.h>

#include <optional>

namespace rubicon::transport {

/// What termios calls a rate; nullopt for one it does not know (termios(3), asm-generic/termbits.h).
std::optional<speed_t> speed_of(unsigned baud);

}  // namespace rubicon::transport
