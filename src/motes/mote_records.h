#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <type_traits>
#include <variant>

#include "base/assert.h"
#include "base/bytes.h"
#include "motes/mote_packet.h"

namespace rubicon::motes {

/// A list of at most kMax trivially copyable values without heap memory, so that records are decoded without
/// allocating. Asserts that it does not overflow.
template <typename T, std::size_t kMax>
class InlineArray {
  static_assert(std::is_trivially_copyable_v<T> && kMax <= 255);

 public:
  InlineArray() = default;
  InlineArray(std::initializer_list<T> values) {
    for (const T& value : values) push_back(value);
  }

  void push_back(const T& value) {
    RUBICON_ASSERT(size_ < kMax);
    values_[size_++] = value;
  }

  static constexpr std::size_t capacity() { return kMax; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t index) const {
    RUBICON_ASSERT(index < size_);
    return values_[index];
  }
  const T& front() const { return (*this)[0]; }
  const T& back() const { return (*this)[size_ - 1]; }
  T& back() {
    RUBICON_ASSERT(size_ > 0);
    return values_[size_ - 1U];
  }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + size_; }

  friend bool operator==(const InlineArray& a, const InlineArray& b) {
    if (a.size_ != b.size_) return false;
    for (std::size_t i = 0; i < a.size_; ++i) {
      if (!(a.values_[i] == b.values_[i])) return false;
    }
    return true;
  }

 private:
  std::array<T, kMax> values_{};
  std::uint8_t size_ = 0;  // small, because the arrays are nested
};

/// Transducer ids = mask bits of the motes (wsn.md 6). kRssi1 carries the readings of all five anchors.
enum class Transducer : std::uint16_t {
  kLight = 0x0001,
  kTemperature = 0x0002,
  kAccelerationX = 0x0004,
  kAccelerationY = 0x0008,
  kPir = 0x0010,
  kMicrophone = 0x0020,
  kHumidity = 0x0040,
  kMagnetic = 0x0080,
  kRssi1 = 0x0100,
  kRssi2 = 0x0200,
  kRssi3 = 0x0400,
  kRssi4 = 0x0800,
  kRssi5 = 0x1000,
};

/// Words that fit into an Updates record after its count (wsn.md 7.1), and the maximum in one item.
inline constexpr std::size_t kMaxUpdateWords = 49;
inline constexpr std::size_t kMaxItemWords = 5;

/// Words that follow this id in an Updates item; 1 for undefined ids.
std::size_t words_of(std::uint16_t transducer);

/// A mote joined (SERIAL_JOINED).
struct Joined {
  std::uint16_t island = 0;
  std::uint16_t mote = 0;
  std::uint8_t mote_type = 0;
  std::uint16_t transducers = 0;
  std::uint8_t actuators = 0;
};

/// Raw readings of one transducer, in wire order.
struct RawReading {
  std::uint16_t transducer = 0;
  InlineArray<std::uint16_t, kMaxItemWords> words;

  friend bool operator==(const RawReading&, const RawReading&) = default;
};

struct RawUpdates {
  /// The shortest item is an id and one word.
  InlineArray<RawReading, kMaxUpdateWords / 2> readings;
};

/// The only two fields of DEMO_DATA that the released firmware fills; the rest is stale memory (wsn.md 7.1).
struct DemoReport {
  std::uint16_t light = 0;
  std::uint16_t temperature = 0;
};

struct ReadUpdates {
  std::uint16_t period_ms = 0;
  std::uint16_t transducers = 0;
};

struct PeriodicCommand {
  std::uint16_t transducers = 0;
  std::uint16_t period_ms = 0;
};

struct ActuateCommand {
  std::uint16_t actuator = 0;
  std::int32_t value = 0;
};

/// Acknowledgement by an application (LEARNING_NOTIFICATION under transport 9): received, not executed.
struct MoteAck {
  std::uint16_t sequence = 0;
  std::uint8_t status = 0;
};

/// A record of another application, with all bytes after it: a view of the message's record.
struct OtherRecord {
  std::uint8_t type = 0;
  ByteView bytes;
};

using Record =
    std::variant<Joined, RawUpdates, DemoReport, ReadUpdates, PeriodicCommand, ActuateCommand, MoteAck, OtherRecord>;

/// Decodes by transport, application and type; ignores the bytes after the record. kInvalid if it is cut short.
Result<Record> decode_record(const NetMessage& message);

/// A radio message and its record.
struct RadioMessage {
  NetMessage header;
  Record record;
};

/// A packet, decoded as far as we know its content. Views of the bytes it was decoded from.
struct DecodedPacket {
  MotePacket packet;
  std::optional<RadioMessage> radio;  ///< in packets of AM type 1C
};

/// Packet, radio message and record in one go. kInvalid if one of them is malformed. Allocates nothing but the text of
/// an error.
Result<DecodedPacket> decode_whole(ByteView bytes);

/// The record alone: not padded, without transport and application.
Bytes encode_record(const Record& record);

/// AM type 25, not part of a NetMsg: the computer sets the sink's island (wsn.md 7.1).
struct ConfigCommand {
  std::uint8_t command = 0;
  std::uint16_t value = 0;
};
inline constexpr std::uint8_t kSetIslandId = 10;

Result<ConfigCommand> decode_config(ByteView payload);
Bytes encode_config(const ConfigCommand& command);

}  // namespace rubicon::motes
