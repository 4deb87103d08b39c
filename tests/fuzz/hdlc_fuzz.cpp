#include <cstdlib>
#include <vector>

#include "fuzz_target.h"
#include "motes/framing.h"

namespace rubicon::fuzz::hdlc_fuzz {

namespace {

struct Heard {
  std::uint8_t protocol = 0, sequence = 0;
  Bytes packet;

  friend bool operator==(const Heard&, const Heard&) = default;
};

std::vector<Heard> hear(motes::HdlcReader& reader, ByteView bytes) {
  std::vector<Heard> heard;
  while (const auto frame = reader.next(bytes))
    heard.push_back({frame->protocol, frame->sequence, Bytes(frame->packet.begin(), frame->packet.end())});
  if (!bytes.empty()) std::abort();
  return heard;
}

Bytes written(const Heard& heard) {
  switch (heard.protocol) {
    case motes::kHdlcAck: return motes::hdlc_ack(heard.sequence);
    case motes::kHdlcAckedPacket: return motes::hdlc_acked_packet(heard.sequence, heard.packet);
    case motes::kHdlcPacket: return motes::hdlc_packet(heard.packet);
    default: std::abort();
  }
}

}  // namespace

/// Input: one byte for the size of the pieces, then the bytes of a serial line. Pieces change nothing, and each frame
/// is read the same from the bytes that we would write for it. What an ack carries is nothing, so it is not compared.
FUZZ_TARGET(hdlc) {
  if (size == 0) return 0;
  const ByteView line(data + 1, size - 1);
  motes::HdlcReader whole, pieces;
  const auto heard = hear(whole, line);
  std::vector<Heard> again;
  const std::size_t piece = data[0] + std::size_t{1};
  for (std::size_t at = 0; at < line.size(); at += piece) {
    for (Heard& one : hear(pieces, line.subspan(at, std::min(piece, line.size() - at)))) again.push_back(one);
  }
  if (again != heard || !(whole.faults() == pieces.faults())) std::abort();
  for (const Heard& one : heard) {
    motes::HdlcReader reader;
    const auto same = hear(reader, written(one));
    if (same.size() != 1 || !(same[0] == one) || !(reader.faults() == motes::HdlcFaults{})) std::abort();
  }
  return 0;
}

}  // namespace rubicon::fuzz::hdlc_fuzz
