#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "motes/hdlc.h"

namespace rubicon::motes_simulator {

/// A frame as it came over the serial line.
struct SerialFrame {
  std::uint8_t protocol = 0;
  std::uint8_t sequence = 0;  ///< of a 44 frame
  Bytes packet;
};

/// How the original sink reads its serial line (wsn.md 10): the flag that ends a frame does not open the next one, so
/// that a frame that shares a flag with the one before is lost, and one behind a frame without a closing flag too.
class SerialReceiver {
 public:
  /// TinyOS's SERIAL_MTU.
  static constexpr std::size_t kLongest = 255;

  std::optional<SerialFrame> take(std::uint8_t byte);
  void reset();

 private:
  enum class Place : std::uint8_t { kHunting, kProtocol, kSequence, kInside };
  std::optional<SerialFrame> flag();
  void plain(std::uint8_t byte);

  Place place_ = Place::kHunting;
  bool escaped_ = false;
  SerialFrame frame_;
};

}  // namespace rubicon::motes_simulator
