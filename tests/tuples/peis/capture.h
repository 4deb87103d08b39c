#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.h"

namespace rubicon::tuples::peis {

/// One direction of a TCP connection, put together from its segments.
struct Stream {
  std::uint16_t from = 0, to = 0;
  bool of_initiator = false;
  Bytes bytes;
};

/// What a recording of Ethernet frames (pcap, little-endian) has of IPv4.
struct Capture {
  std::vector<Bytes> datagrams;  ///< payloads of UDP, in order
  std::vector<Stream> streams;   ///< in the order of their first segments
};

/// The recordings of tests/cases/peis, by name without `.pcap`.
std::vector<std::string> capture_names();
/// Adds a failure of the test for what it cannot read: other frames, gaps in a stream.
Capture read_capture(const std::string& name);

}  // namespace rubicon::tuples::peis
