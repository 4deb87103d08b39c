#include "apps/simulators/motes/serial_receiver.h"

#include <utility>

namespace rubicon::motes_simulator {

namespace {

constexpr std::uint8_t kFlag = 0x7e;
constexpr std::uint8_t kEscape = 0x7d;
constexpr std::uint8_t kFlipped = 0x20;
constexpr std::size_t kCrcBytes = 2;

bool crc_good(SerialFrame& frame) {
  auto& bytes = frame.packet;
  if (bytes.size() < kCrcBytes) return false;
  const auto told = static_cast<std::uint16_t>(bytes[bytes.size() - 2] | bytes[bytes.size() - 1] << 8U);
  bytes.resize(bytes.size() - kCrcBytes);
  const std::uint8_t head[] = {frame.protocol, frame.sequence};
  const std::size_t length = frame.protocol == motes::kHdlcAckedPacket ? 2 : 1;
  return motes::crc16(bytes, motes::crc16({head, length})) == told;
}

}  // namespace

void SerialReceiver::reset() {
  place_ = Place::kHunting;
  escaped_ = false;
  frame_ = {};
}

std::optional<SerialFrame> SerialReceiver::take(std::uint8_t byte) {
  if (byte == kFlag) return flag();
  if (place_ == Place::kHunting) return std::nullopt;
  if (byte == kEscape) {
    escaped_ = true;
    return std::nullopt;
  }
  plain(std::exchange(escaped_, false) ? static_cast<std::uint8_t>(byte ^ kFlipped) : byte);
  return std::nullopt;
}

std::optional<SerialFrame> SerialReceiver::flag() {
  const auto place = place_;
  auto frame = std::move(frame_);
  reset();
  if (place == Place::kHunting || place == Place::kProtocol) {
    place_ = Place::kProtocol;
    return std::nullopt;
  }
  if (place != Place::kInside || !crc_good(frame)) return std::nullopt;
  return frame;
}

void SerialReceiver::plain(std::uint8_t byte) {
  switch (place_) {
    case Place::kProtocol:
      frame_.protocol = byte;
      if (byte == motes::kHdlcAckedPacket) {
        place_ = Place::kSequence;
      } else if (byte == motes::kHdlcPacket) {
        place_ = Place::kInside;
      } else {
        reset();
      }
      return;
    case Place::kSequence:
      frame_.sequence = byte;
      place_ = Place::kInside;
      return;
    case Place::kInside:
      if (frame_.packet.size() >= kLongest + kCrcBytes) return reset();
      frame_.packet.push_back(byte);
      return;
    case Place::kHunting: return;
  }
}

}  // namespace rubicon::motes_simulator
