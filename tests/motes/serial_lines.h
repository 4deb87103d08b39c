#pragma once

#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "motes/framing.h"

namespace rubicon::motes {

inline Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}

/// wsn.md 15 writes `00*91` for 91 zero bytes.
inline Bytes padded(std::string_view front, std::size_t zeros, std::string_view back) {
  Bytes out = hex(front);
  out.insert(out.end(), zeros, 0);
  const Bytes end = hex(back);
  out.insert(out.end(), end.begin(), end.end());
  return out;
}

inline Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

/// What a reader heard, kept: a frame's own packet is a view.
struct Heard {
  std::uint8_t protocol = 0, sequence = 0;
  Bytes packet;

  friend bool operator==(const Heard&, const Heard&) = default;
};

/// So that a failing test prints it.
inline void PrintTo(const Heard& heard, std::ostream* out) {
  *out << base::to_hex(std::array{heard.protocol, heard.sequence}) << " " << base::to_hex(heard.packet);
}

inline void PrintTo(const HdlcFaults& faults, std::ostream* out) {
  *out << "bad CRC " << faults.bad_crc << ", too short " << faults.too_short << ", too long " << faults.too_long
       << ", broken escapes " << faults.broken_escapes << ", unknown protocols " << faults.unknown_protocols
       << ", bytes between " << faults.bytes_between;
}

inline void hear(HdlcReader& reader, ByteView bytes, std::vector<Heard>& heard) {
  while (const auto frame = reader.next(bytes))
    heard.push_back({frame->protocol, frame->sequence, Bytes(frame->packet.begin(), frame->packet.end())});
}

inline std::vector<Heard> heard_in(ByteView bytes) {
  HdlcReader reader;
  std::vector<Heard> heard;
  hear(reader, bytes, heard);
  return heard;
}

/// The pieces that `next_size()` cuts.
template <typename Size>
std::vector<Heard> heard_in_pieces(ByteView bytes, Size next_size) {
  HdlcReader reader;
  std::vector<Heard> heard;
  while (!bytes.empty()) {
    const ByteView piece = bytes.first(std::min<std::size_t>(next_size(), bytes.size()));
    hear(reader, piece, heard);
    bytes = bytes.subspan(piece.size());
  }
  return heard;
}

/// The frame it came in, as we would write it.
inline Bytes written(const Heard& heard) {
  switch (heard.protocol) {
    case kHdlcAck: return hdlc_ack(heard.sequence);
    case kHdlcAckedPacket: return hdlc_acked_packet(heard.sequence, heard.packet);
    default: return hdlc_packet(heard.packet);
  }
}

/// A file of the shared recordings; empty where they are absent.
inline Bytes recorded(const std::string& name) {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/motes/" + name, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string content = text.str();
  return Bytes(content.begin(), content.end());
}

}  // namespace rubicon::motes
