#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace rubicon::recording {

/// Integers in little-endian order, as in the heads of the format; the caller provides enough bytes.
template <class Number>
void put_le(std::uint8_t* to, Number number) {
  auto rest = static_cast<std::uint64_t>(number);
  for (std::size_t i = 0; i < sizeof(Number); ++i, rest >>= 8U) to[i] = static_cast<std::uint8_t>(rest);
}

template <class Number>
Number get_le(const std::uint8_t* from) {
  std::uint64_t sum = 0;
  for (std::size_t i = sizeof(Number); i-- > 0;) sum = sum << 8U | from[i];
  return static_cast<Number>(sum);
}

}  // namespace rubicon::recording
