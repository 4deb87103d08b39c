#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rubicon::web::server {

constexpr int kText = 1, kBinary = 2, kClose = 8, kPing = 9;

/// A frame of a client (RFC 6455, section 5.2), masked with zeros.
inline std::string frame(int opcode, std::string_view payload, bool last = true, bool masked = true) {
  std::string bytes(1, static_cast<char>((last ? 0x80 : 0) | opcode));
  const int mask = masked ? 0x80 : 0;
  if (payload.size() < 126) {
    bytes += static_cast<char>(mask | static_cast<int>(payload.size()));
  } else if (payload.size() < 65536) {
    bytes += static_cast<char>(mask | 126);
    for (int shift = 8; shift >= 0; shift -= 8)
      bytes += static_cast<char>(payload.size() >> static_cast<unsigned>(shift));
  } else {
    bytes += static_cast<char>(mask | 127);
    for (int shift = 56; shift >= 0; shift -= 8)
      bytes += static_cast<char>(payload.size() >> static_cast<unsigned>(shift));
  }
  if (masked) bytes += std::string(4, '\0');
  return bytes + std::string(payload);
}

/// The first bytes of a close frame of the server with this code.
inline std::string close_code(int code) {
  return {static_cast<char>(code >> 8), static_cast<char>(code & 0xff)};
}

inline const std::string kUpgrade =
    "GET /api/v1/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

}  // namespace rubicon::web::server
