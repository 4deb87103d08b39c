#include "apps/rubicon-motes/message_memory.h"

#include <algorithm>

#include "base/assert.h"

namespace rubicon::mote_simulator {

void MessageMemory::clear() {
  for (auto& buffer : buffers_) buffer.fill(0);
}

MessageMemory::Buffer& MessageMemory::buffer() {
  auto& one = buffers_[dice_() % buffers_.size()];
  if (std::uniform_real_distribution<>(0, 1)(dice_) >= stale_) one.fill(0);
  return one;
}

Bytes MessageMemory::wrap(motes::NetMessage& message, const Buffer& buffer) {
  message.record = buffer;
  return motes::encode_net(message);
}

Bytes MessageMemory::build(motes::NetMessage message) {
  RUBICON_ASSERT(message.record.size() <= kRecordRoom);
  auto& room = buffer();
  std::copy(message.record.begin(), message.record.end(), room.begin());
  return wrap(message, room);
}

Bytes MessageMemory::build_ack(motes::NetMessage message) {
  RUBICON_ASSERT(message.record.size() < kRecordRoom);
  auto& room = buffer();
  const auto behind = std::copy(message.record.begin(), message.record.end(), room.begin());
  *behind = static_cast<std::uint8_t>(0x60U + dice_() % 16U);
  return wrap(message, room);
}

}  // namespace rubicon::mote_simulator
