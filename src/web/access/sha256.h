#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace rubicon::web::access {

using Digest = std::array<std::uint8_t, 32>;

/// FIPS 180-4.
Digest sha256(std::string_view bytes);
/// Takes the same time for all inputs.
bool same(const Digest& a, const Digest& b);
std::string hex(const std::uint8_t* bytes, std::size_t size);
/// 128 random bits in 32 hexadecimal digits, from the system's source.
std::string random_secret();

}  // namespace rubicon::web::access
