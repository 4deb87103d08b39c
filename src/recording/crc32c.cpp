#include "recording/crc32c.h"

#include <array>

namespace rubicon::recording {

namespace {

constexpr std::uint32_t kReflected = 0x82f63b78;
using Table = std::array<std::array<std::uint32_t, 256>, 8>;

/// Eight bytes a step: row n holds the remainders of a byte that is followed by n zero bytes.
constexpr Table make_table() {
  Table table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1U) ^ ((rest & 1U) != 0 ? kReflected : 0U);
    table[0][byte] = rest;
  }
  for (std::size_t row = 1; row < 8; ++row) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = table[row - 1][byte];
      table[row][byte] = (before >> 8U) ^ table[0][before & 0xffU];
    }
  }
  return table;
}

constexpr Table kTable = make_table();

}  // namespace

std::uint32_t crc32c(ByteView bytes) {
  std::uint32_t rest = 0xffffffff;
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    const std::uint8_t* p = bytes.data() + at;
    const std::uint32_t low = rest ^ (std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8U | std::uint32_t{p[2]} << 16U |
                                      std::uint32_t{p[3]} << 24U);
    rest = kTable[7][low & 0xffU] ^ kTable[6][(low >> 8U) & 0xffU] ^ kTable[5][(low >> 16U) & 0xffU] ^
           kTable[4][low >> 24U] ^ kTable[3][p[4]] ^ kTable[2][p[5]] ^ kTable[1][p[6]] ^ kTable[0][p[7]];
  }
  for (; at < bytes.size(); ++at) rest = (rest >> 8U) ^ kTable[0][(rest ^ bytes[at]) & 0xffU];
  return ~rest;
}

}  // namespace rubicon::recording
