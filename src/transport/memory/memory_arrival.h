#pragma once

#include <algorithm>

#include "base/bytes.h"

namespace rubicon::transport {

/// Bytes reach an end of a stream of memory in pieces of `segment` (0 = one piece), as long as it is open and not held;
/// what it does not take is kept for when it is let go.
template <class End>
void arrive_at(End& end, ByteView bytes, std::size_t segment) {
  const auto piece = segment == 0 ? bytes.size() : segment;
  while (!bytes.empty() && end.alive && !end.lost && !end.held) {
    const ByteView next = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(next.size());
    if (end.calls.received) end.calls.received(next);
  }
  if (end.held) end.kept.insert(end.kept.end(), bytes.begin(), bytes.end());
}

}  // namespace rubicon::transport
