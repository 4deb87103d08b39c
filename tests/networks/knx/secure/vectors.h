#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/secure/crypto.h"

namespace rubicon::networks::knx::secure {

inline Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}

template <class Array>
Array array_of(std::string_view text) {
  const auto bytes = hex(text);
  Array out{};
  std::copy_n(bytes.begin(), std::min(bytes.size(), out.size()), out.begin());
  return out;
}

inline Key key_of(std::string_view text) {
  return Key::from(hex(text)).value();
}

/// The reference material beside the tree; tests that need it are skipped where it is absent.
inline std::string shared_data(const std::string& name) {
  return std::string(RUBICON_SOURCE_DIR) + "/../shared/data/" + name;
}

/// Bytes that count up from `first`: `01 02 03 ..`, the private keys of the worked vectors (knx.md, section 18).
inline Secret counting(std::uint8_t first, std::size_t size = 32) {
  Secret bytes(size);
  for (auto& byte : bytes.span()) byte = first++;
  return bytes;
}

}  // namespace rubicon::networks::knx::secure
