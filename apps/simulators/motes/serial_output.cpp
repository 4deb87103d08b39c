#include "apps/simulators/motes/serial_output.h"

#include <utility>

#include "motes/hdlc.h"

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

}  // namespace rubicon::motes_simulator
