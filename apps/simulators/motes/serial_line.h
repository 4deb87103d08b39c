#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "base/bytes.h"
#include "base/scheduler.h"
#include "motes/framing.h"

namespace rubicon::motes_simulator {

/// The serial line from the sink to the computer: frames leave one after the other at the line's rate. Buffers two
/// messages, including the one on the wire (wsn.md 12), and separately acknowledgements, which are sent first.
class SerialOutput {
 public:
  using Out = std::function<void(ByteView bytes)>;
  static constexpr std::size_t kBuffers = 2;
  static constexpr std::size_t kAcks = 32;

  SerialOutput(unsigned baud, Scheduler& scheduler) : baud_(baud), scheduler_(scheduler) {}

  /// Receives each frame when its last bit was sent; without it frames are lost.
  void connect(Out out) { out_ = std::move(out); }
  /// False: the buffers are full, the packet is lost.
  bool packet(ByteView packet);
  bool ack(std::uint8_t sequence);
  void reset();

  /// Time for bytes of 8 data bits, a start and a stop bit; baud 0: none.
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

/// A frame from the serial line.
struct SerialFrame {
  std::uint8_t protocol = 0;
  std::uint8_t sequence = 0;  ///< of a 44 frame
  Bytes packet;
};

/// Reads the serial line like the original sink (wsn.md 10): the flag that ends a frame does not start the next one, so
/// that a frame is lost if it shares a flag with the previous one, or follows one without a closing flag.
class SerialReceiver {
 public:
  /// TinyOS's SERIAL_MTU.
  static constexpr std::size_t kMaxPacket = 255;

  std::optional<SerialFrame> take(std::uint8_t byte);
  void reset();

 private:
  enum class State : std::uint8_t { kHunting, kProtocol, kSequence, kInside };
  std::optional<SerialFrame> take_flag();
  void take_plain(std::uint8_t byte);

  State state_ = State::kHunting;
  bool escaped_ = false;
  SerialFrame frame_;
};

}  // namespace rubicon::motes_simulator
