#pragma once

#include <string>
#include <string_view>

namespace rubicon::networks::knx::dpt {

/// A line of `rubicon knx decode`: `9.001 0c33` -> `21.5`. Values are in the unit of the KNX table, numbers in the
/// shortest text that reads back, bits and enumerations as their word (`down`, `reserved (7)`), structures as JSON.
/// Text that is empty or has control characters is quoted as in JSON. Hex may have blanks; types of up to 6 bits have
/// one octet. The result is `error: ...` if the line cannot be read.
std::string decode_line(std::string_view line);
/// A line of `rubicon knx encode`: `9.001 21.5` -> `0c33`; accepts what decode_line() returns and everything that
/// encode_text() accepts.
std::string encode_line(std::string_view line);

}  // namespace rubicon::networks::knx::dpt
