#pragma once

#include <string>
#include <string_view>

namespace rubicon::networks::knx::dpt {

/// A line of `rubicon knx decode`: `9.001 0c33` -> `21.5`. Values are in the table's own unit, numbers in the shortest
/// text that reads back, bits and enumerations as their word (`down`, `reserved (7)`), records as JSON. Text with
/// control characters, or none at all, stands in quotes as in JSON. Hex may have blanks; types of up to 6 bits have
/// one octet. `error: why` for what cannot be read.
std::string decode_line(std::string_view line);
/// A line of `rubicon knx encode`: `9.001 21.5` -> `0c33`; reads what decode_line writes, and all that encode_text
/// reads.
std::string encode_line(std::string_view line);

}  // namespace rubicon::networks::knx::dpt
