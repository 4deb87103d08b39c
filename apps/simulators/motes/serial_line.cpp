#include "apps/simulators/motes/serial_line.h"

#include <utility>

#include "motes/framing.h"

namespace rubicon::motes_simulator {

Duration SerialOutput::line_time(std::size_t bytes, unsigned baud) {
  if (baud == 0) return {};
  return Duration(std::chrono::nanoseconds(10'000'000'000ULL * bytes / baud));
}

bool SerialOutput::packet(ByteView packet) {
  if (packets_.size() >= kBuffers) return false;
  packets_.push_back(motes::hdlc_packet(packet));
  pump();
  return true;
}

bool SerialOutput::ack(std::uint8_t sequence) {
  if (acks_.size() >= kAcks) return false;
  acks_.push_back(sequence);
  pump();
  return true;
}

void SerialOutput::reset() {
  packets_.clear();
  acks_.clear();
  frame_.clear();
  timer_.cancel();
}

void SerialOutput::pump() {
  if (timer_.pending() || (acks_.empty() && packets_.empty())) return;
  ack_leaves_ = !acks_.empty();
  frame_ = ack_leaves_ ? motes::hdlc_ack(acks_.front()) : packets_.front();
  timer_ = scheduler_.after(line_time(frame_.size(), baud_), [this] { left(); });
}

void SerialOutput::left() {
  const auto frame = std::exchange(frame_, {});
  if (ack_leaves_) {
    acks_.pop_front();
  } else {
    packets_.pop_front();
  }
  pump();
  if (out_) out_(frame);
}

namespace {

constexpr std::uint8_t kFlag = 0x7e;
constexpr std::uint8_t kEscape = 0x7d;
constexpr std::uint8_t kEscapeBit = 0x20;
constexpr std::size_t kCrcBytes = 2;

bool remove_valid_crc(SerialFrame& frame) {
  auto& bytes = frame.packet;
  if (bytes.size() < kCrcBytes) return false;
  const auto crc = static_cast<std::uint16_t>(bytes[bytes.size() - 2] | bytes[bytes.size() - 1] << 8U);
  bytes.resize(bytes.size() - kCrcBytes);
  const std::uint8_t head[] = {frame.protocol, frame.sequence};
  const std::size_t length = frame.protocol == motes::kHdlcAckedPacket ? 2 : 1;
  return motes::crc16(bytes, motes::crc16({head, length})) == crc;
}

}  // namespace

void SerialReceiver::reset() {
  state_ = State::kHunting;
  escaped_ = false;
  frame_ = {};
}

std::optional<SerialFrame> SerialReceiver::take(std::uint8_t byte) {
  if (byte == kFlag) return take_flag();
  if (state_ == State::kHunting) return std::nullopt;
  if (byte == kEscape) {
    escaped_ = true;
    return std::nullopt;
  }
  take_plain(std::exchange(escaped_, false) ? static_cast<std::uint8_t>(byte ^ kEscapeBit) : byte);
  return std::nullopt;
}

std::optional<SerialFrame> SerialReceiver::take_flag() {
  const auto state = state_;
  auto frame = std::move(frame_);
  reset();
  if (state == State::kHunting || state == State::kProtocol) {
    state_ = State::kProtocol;
    return std::nullopt;
  }
  if (state != State::kInside || !remove_valid_crc(frame)) return std::nullopt;
  return frame;
}

void SerialReceiver::take_plain(std::uint8_t byte) {
  switch (state_) {
    case State::kProtocol:
      frame_.protocol = byte;
      if (byte == motes::kHdlcAckedPacket) {
        state_ = State::kSequence;
      } else if (byte == motes::kHdlcPacket) {
        state_ = State::kInside;
      } else {
        reset();
      }
      return;
    case State::kSequence:
      frame_.sequence = byte;
      state_ = State::kInside;
      return;
    case State::kInside:
      if (frame_.packet.size() >= kMaxPacket + kCrcBytes) return reset();
      frame_.packet.push_back(byte);
      return;
    case State::kHunting: return;
  }
}

}  // namespace rubicon::motes_simulator
