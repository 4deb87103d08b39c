#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "motes/hdlc.h"

namespace rubicon::motes_simulator {

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
