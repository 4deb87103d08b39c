#pragma once

#include <gtest/gtest.h>

#include "base/bytes.h"

namespace rubicon::networks::knx::wire {

inline Bytes bytes_of(std::string_view hex) {
  auto bytes = base::from_hex(hex);
  EXPECT_TRUE(bytes) << hex;
  return bytes ? *bytes : Bytes{};
}

}  // namespace rubicon::networks::knx::wire
