#include "apps/simulators/motes/message_memory.h"

#include <algorithm>

#include "base/assert.h"

namespace rubicon::motes_simulator {

MessageMemory::Room MessageMemory::room() {
  Room room{};
  const bool stale = std::uniform_real_distribution<>(0, 1)(rng_) < stale_;
  if (!stale || last_.empty()) return room;
  const auto from = static_cast<std::ptrdiff_t>(rng_() % last_.size());
  const auto count = std::min<std::ptrdiff_t>(std::ssize(last_) - from, std::ssize(room));
  std::copy_n(last_.begin() + from, count, room.end() - count);
  std::copy_n(last_.begin(), std::ssize(room) - count, room.begin());
  return room;
}

Bytes MessageMemory::wrap(motes::NetMessage& message, const Room& room) {
  message.record = room;
  last_ = motes::encode_net(message);
  return last_;
}

Bytes MessageMemory::build(motes::NetMessage message) {
  RUBICON_ASSERT(message.record.size() <= kRecordRoom);
  auto into = room();
  std::copy(message.record.begin(), message.record.end(), into.begin());
  return wrap(message, into);
}

Bytes MessageMemory::build_ack(motes::NetMessage message) {
  RUBICON_ASSERT(message.record.size() < kRecordRoom);
  auto into = room();
  const auto next = std::copy(message.record.begin(), message.record.end(), into.begin());
  *next = static_cast<std::uint8_t>(0x60U + rng_() % 16U);
  return wrap(message, into);
}

}  // namespace rubicon::motes_simulator
