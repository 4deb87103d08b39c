#pragma once

#include <cstdint>

#include "base/bytes.h"

namespace rubicon::recording {

/// CRC-32C (Castagnoli; polynomial 1EDC6F41, reflected 82F63B78; initial value and final xor FFFFFFFF), as in RFC 3720,
/// appendix B.4.
std::uint32_t crc32c(ByteView bytes);

}  // namespace rubicon::recording
