#pragma once

#include <cstdint>
#include <deque>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// The frames of the last minutes, as they stood on the wire, bounded in time and memory.
class Capture {
 public:
  struct Frame {
    std::uint64_t number = 0;  ///< counts up from 1
    WallTime time{};
    bool outgoing = false;
    Bytes cemi;
  };
  struct Limits {
    Duration age = std::chrono::minutes(10);
    std::size_t bytes = 1UL << 20;
  };

  explicit Capture(Limits limits) : limits_(limits) {}

  void add(ByteView cemi, bool outgoing, WallTime now);
  const std::deque<Frame>& frames() const { return frames_; }
  /// Other bounds from the next frame on.
  void limit(Limits limits) { limits_ = limits; }

 private:
  Limits limits_;
  std::size_t bytes_ = 0;
  std::uint64_t last_ = 0;
  std::deque<Frame> frames_;
};

/// The head of a pcap file of raw IPv4 packets (LINKTYPE_RAW 101).
Bytes pcap_head();
/// One frame as a pcap record: a ROUTING_INDICATION to 224.0.23.12:3671, which every analyser of KNXnet/IP reads; ours
/// come from 127.0.0.1, others from 127.0.0.2. The packets never were on a network.
Bytes pcap_record(const Capture::Frame& frame);

}  // namespace rubicon::networks::knx
