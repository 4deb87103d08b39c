#pragma once

#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "base/bytes.h"

namespace rubicon::motes {

struct Vector {
  std::string name, kind, meaning;
  Bytes bytes;
};

/// The shared test vectors, empty where they are absent.
inline std::vector<Vector> shared_vectors() {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/motes/vectors.tsv");
  std::vector<Vector> vectors;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) continue;
    std::istringstream columns(line);
    Vector vector;
    std::string hex;
    std::getline(columns, vector.name, '\t');
    std::getline(columns, vector.kind, '\t');
    std::getline(columns, hex, '\t');
    std::getline(columns, vector.meaning, '\t');
    vector.bytes = base::from_hex(hex).value_or(Bytes{});
    vectors.push_back(vector);
  }
  return vectors;
}

/// The packet in a whole HDLC frame (wsn.md 2): flags, escapes, protocol byte, serial sequence and CRC taken off.
inline std::optional<Bytes> packet_in_frame(const Bytes& frame) {
  Bytes inner;
  for (std::size_t i = 1; i + 1 < frame.size(); ++i) {
    if (frame[i] == 0x7d && i + 2 < frame.size())
      inner.push_back(static_cast<std::uint8_t>(frame[++i] ^ 0x20));
    else
      inner.push_back(frame[i]);
  }
  const std::size_t header = inner.size() > 0 && inner[0] == 0x45 ? 1 : 2;
  if (inner.size() < header + 10 || (inner[0] != 0x44 && inner[0] != 0x45)) return std::nullopt;
  return Bytes(inner.begin() + static_cast<std::ptrdiff_t>(header), inner.end() - 2);
}

/// The packets of a vector: of one frame, of the forwarder's protocol, or of recorder records.
inline std::vector<Bytes> packets_of(const Vector& vector) {
  std::vector<Bytes> packets;
  if (vector.kind == "hdlc") {
    if (auto packet = packet_in_frame(vector.bytes)) packets.push_back(*packet);
  } else if (vector.kind == "sf") {
    packets.emplace_back(vector.bytes.begin() + 1, vector.bytes.end());
  } else if (vector.kind == "log") {
    for (std::size_t at = 0; at + 13 < vector.bytes.size();) {
      const std::size_t length = vector.bytes[at + 12];
      const auto first = vector.bytes.begin() + static_cast<std::ptrdiff_t>(at + 13);
      packets.emplace_back(first, first + static_cast<std::ptrdiff_t>(length));
      at += 13 + length;
    }
  }
  return packets;
}

}  // namespace rubicon::motes
