#pragma once

#include <cstdint>
#include <deque>
#include <utility>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// The cEMI frames that were received and sent last, bounded in age and memory.
class Capture {
 public:
  struct Frame {
    std::uint64_t number = 0;  ///< consecutive, from 1
    WallTime time{};
    bool outgoing = false;
    Bytes cemi;
  };
  struct Limits {
    Duration age = std::chrono::minutes(10);
    std::size_t bytes = 1UL << 20;  ///< of frames, with what their storage takes
  };

  explicit Capture(Limits limits) : limits_(limits) {}

  void add(ByteView cemi, bool outgoing, WallTime now);
  const std::deque<Frame>& frames() const { return frames_; }
  /// The next added frame applies them.
  void set_limits(Limits limits) { limits_ = limits; }

 private:
  Limits limits_;
  std::size_t bytes_ = 0;
  std::uint64_t last_ = 0;
  std::deque<Frame> frames_;
};

/// The header of a pcap file of raw IPv4 packets (LINKTYPE_RAW 101).
Bytes pcap_file_header();
/// A frame as a pcap record. The packet is made up, for analysers of KNXnet/IP: a ROUTING_INDICATION to
/// 224.0.23.12:3671, from 127.0.0.1 for frames that were sent and from 127.0.0.2 for received ones.
Bytes pcap_record(const Capture::Frame& frame);

/// Finds telegrams that the bus repeated: a frame that is marked as repeated and equals another one of the last 200 ms
/// is the same telegram (knx.md, section 8).
class Repetitions {
 public:
  /// Whether this telegram was taken before. If not, it is remembered.
  bool contain(const wire::Telegram& telegram, SteadyTime now);
  std::uint64_t count() const { return count_; }

 private:
  std::deque<std::pair<SteadyTime, wire::Telegram>> recent_;
  std::uint64_t count_ = 0;
};

}  // namespace rubicon::networks::knx
