#pragma once

#include <cstdint>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::wire {

/// The service of a group telegram (KNX 3/3/7): APCI 000, 040, 080.
enum class Service : std::uint8_t { kRead, kResponse, kWrite };

/// Numbered as on the wire (KNX 3/6/3, Ctrl1 b3-2). System is the highest, then urgent, normal, low.
enum class Priority : std::uint8_t { kSystem, kNormal, kUrgent, kLow };

/// The value in a telegram. `small`: a value of up to 6 bits that is part of the APCI byte; `bytes` then has one byte
/// of 0..63. Values of 8 bits or more never have this form, even if they would fit.
struct PayloadView {
  ByteView bytes;
  bool small = false;
};

struct Payload {
  Bytes bytes;  ///< at most 253 (kMaxPayload)
  bool small = false;

  operator PayloadView() const { return {bytes, small}; }
  friend bool operator==(const Payload&, const Payload&) = default;
};

/// A telegram to a group address, received or to be sent.
struct Telegram {
  Service service = Service::kWrite;
  GroupAddress destination{};
  Payload payload;             ///< empty in a read
  IndividualAddress source{};  ///< 0.0.0 in a telegram to be sent: the server or the line sets it
  Priority priority = Priority::kLow;
  std::uint8_t hops = 6;  ///< 0..7
  bool repeated = false;  ///< received: a repetition on the bus (Ctrl1 b5 = 0)

  friend bool operator==(const Telegram&, const Telegram&) = default;
};

}  // namespace rubicon::networks::knx::wire
