#pragma once

#include <algorithm>

#include "base/bytes.h"

namespace rubicon::transport {

/// Delivers bytes to an end of an in-memory stream in pieces of `segment` bytes (0 = one piece) while it is open and
/// not held; keeps the rest for the end of the hold.
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
