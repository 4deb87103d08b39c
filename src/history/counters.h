#pragma once

#include <cstdint>

namespace rubicon::history {

/// What a history did since it began.
struct Counters {
  std::uint64_t points = 0;    ///< written
  std::uint64_t dropped = 0;   ///< that could not be written
  std::uint64_t failures = 0;  ///< to open, write and read the file
  std::uint64_t bytes = 0;     ///< present size of the file
  bool recording = false;      ///< the file is open, and all is written
};

}  // namespace rubicon::history
