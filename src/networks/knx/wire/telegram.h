#pragma once

#include <cstdint>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::wire {

/// What a group telegram does (KNX 3/3/7): APCI 000, 040, 080.
enum class Service : std::uint8_t { kRead, kResponse, kWrite };

/// In the order of the wire (KNX 3/6/3, Ctrl1 b3-2); system goes first, then urgent, normal, low.
enum class Priority : std::uint8_t { kSystem, kNormal, kUrgent, kLow };

/// The value in a telegram. `small`: 0..63 inside the APCI byte, `bytes` is one byte then; a value of a byte or more
/// never uses that form, even when it would fit.
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

/// A telegram to a group, as it was heard or is to be sent.
struct Telegram {
  Service service = Service::kWrite;
  GroupAddress destination{};
  Payload payload;             ///< empty in a read
  IndividualAddress source{};  ///< 0.0.0 when sending: the server or the configuration fills it in
  Priority priority = Priority::kLow;
  std::uint8_t hops = 6;  ///< 0..7
  bool repeated = false;  ///< heard: a repetition on the bus (Ctrl1 b5 = 0)

  friend bool operator==(const Telegram&, const Telegram&) = default;
};

}  // namespace rubicon::networks::knx::wire
