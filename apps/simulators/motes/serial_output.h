#pragma once

#include <cstdint>
#include <deque>
#include <functional>

#include "base/bytes.h"
#include "base/scheduler.h"

namespace rubicon::motes_simulator {

/// The sink's way out to the computer: frames leave one after the other at the line's rate. Two messages have room, the
/// one on the wire counted (wsn.md 12); acknowledgements are apart and go before them.
class SerialOutput {
 public:
  using Out = std::function<void(ByteView bytes)>;
  static constexpr std::size_t kBuffers = 2;
  static constexpr std::size_t kAcks = 32;

  SerialOutput(unsigned baud, Scheduler& scheduler) : baud_(baud), scheduler_(scheduler) {}

  /// Where bytes go, a frame at a time when its last bit has left; without it they are lost.
  void connect(Out out) { out_ = std::move(out); }
  /// False: no room, it is lost.
  bool packet(ByteView packet);
  bool ack(std::uint8_t sequence);
  void reset();

  /// 8 data bits, a start and a stop bit; baud 0 = no time at all.
  static Duration line_time(std::size_t bytes, unsigned baud);

 private:
  void pump();
  void left();

  unsigned baud_;
  Scheduler& scheduler_;
  Out out_;
  std::deque<Bytes> packets_;
  std::deque<std::uint8_t> acks_;
  bool ack_leaves_ = false;
  Bytes frame_;  ///< on the wire
  Timer timer_;
};

}  // namespace rubicon::motes_simulator
