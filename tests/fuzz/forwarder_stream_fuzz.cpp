#include <algorithm>
#include <cstdlib>
#include <vector>

#include "fuzz_target.h"
#include "motes/framing.h"

namespace rubicon::fuzz::forwarder_stream_fuzz {

namespace {

struct Read {
  std::vector<Bytes> packets;
  bool greeted = false, fault = false;
};

Read read_in_pieces(ByteView bytes, std::size_t piece) {
  motes::ForwarderReader reader;
  Read read;
  while (!bytes.empty() && !read.fault) {
    ByteView next = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(next.size());
    for (;;) {
      const auto packet = reader.next(next);
      read.fault = !packet;
      if (!packet && packet.error().text.empty()) std::abort();
      if (!packet || !*packet) break;
      read.packets.emplace_back((*packet)->begin(), (*packet)->end());
    }
    if (!read.fault && !next.empty()) std::abort();
  }
  read.greeted = reader.greeted();
  return read;
}

}  // namespace

/// Input: how long the pieces are in which the rest, one direction of a connection, comes (one byte).
FUZZ_TARGET(forwarder_stream) {
  if (size < 1) return 0;
  const ByteView bytes(data + 1, size - 1);
  const auto whole = read_in_pieces(bytes, bytes.size());
  const auto pieces = read_in_pieces(bytes, std::size_t{1} + data[0]);
  if (whole.packets != pieces.packets || whole.greeted != pieces.greeted || whole.fault != pieces.fault) std::abort();
  if (!whole.greeted && !whole.packets.empty()) std::abort();
  // What was read is what stands there.
  Bytes written(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(2, bytes.size())));
  for (const auto& packet : whole.packets) {
    if (packet.empty() || packet.size() > 255) std::abort();
    const auto framed = motes::forwarder_packet(packet);
    written.insert(written.end(), framed.begin(), framed.end());
  }
  if (written.size() > bytes.size() || !std::equal(written.begin(), written.end(), bytes.begin())) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::forwarder_stream_fuzz
