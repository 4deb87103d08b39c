#include "tuples/dds/channel.h"

#include <fmt/format.h>

#include <algorithm>

#include "tuples/dds/entity.h"
#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

/// Approximate size of an entry besides its texts.
constexpr std::size_t kOverhead = 64;

Qos writer_qos() {
  auto qos = make_qos();
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  dds_qset_ignorelocal(qos.get(),
                       DDS_IGNORELOCAL_PARTICIPANT);  // the reader in this participant is not the destination
  return qos;
}

}  // namespace

Result<std::unique_ptr<Channel>> Channel::make(const Ends& ends, dds_entity_t participant, dds_entity_t topic,
                                               const dds_listener_t* listener) {
  const auto partition = fmt::format("{}.{}", hex_id(ends.source), hex_id(ends.target));
  auto qos = make_qos();
  dds_qset_partition1(qos.get(), partition.c_str());
  auto publisher = made(dds_create_publisher(participant, qos.get(), nullptr), "publisher " + partition);
  if (!publisher) return fail(std::move(publisher.error()));
  auto writer = made(dds_create_writer(publisher->get(), topic, writer_qos().get(), listener), "writer " + partition);
  if (!writer) return fail(std::move(writer.error()));
  return std::unique_ptr<Channel>(new Channel(ends, std::move(*publisher), std::move(*writer)));
}

void Channel::push(Entry entry, std::size_t size) {
  entries_.emplace_back(std::move(entry), size);
  waiting_ += size;
}

void Channel::add(Bytes changes) {
  const auto size = changes.size();
  push(std::move(changes), size);
}

void Channel::add(RemoteSet set, SteadyTime now) {
  const auto size = set.key.size() + set.value.size() + kOverhead;
  push(TimedSet{std::move(set), now}, size);
}

void Channel::add(Reply reply) {
  const auto size = reply.text.size() + kOverhead;
  push(std::move(reply), size);
}

void Channel::add(const distant::IdentityCheck& check) {
  distant::FrameWriter entry;
  entry.add(check);
  add(entry.take());
}

void Channel::add_times(bool asks) {
  times_due_ = true;
  asks_ |= asks;
}

bool Channel::has_readers() {
  if (matched_) return true;
  dds_publication_matched_status_t status;
  if (dds_get_publication_matched_status(writer_.get(), &status) != 0) return false;
  matched_ = status.current_count > 0;
  return matched_;
}

/// Encodes the first entries into the frame and returns their number. Leaves out remote sets whose time to live ended.
std::size_t Channel::fill(SteadyTime now, const Times& times) {
  frame_.clear();
  if (times) frame_.add(times(asks_));
  const auto begin = frame_.size();
  std::size_t count = 0;
  for (; count < entries_.size(); ++count) {
    const auto& [entry, size] = entries_[count];
    if (frame_.size() > begin && frame_.size() + size > kFrameBytes) break;
    if (const auto* changes = std::get_if<Bytes>(&entry)) {
      frame_.add(ByteView(*changes));
    } else if (const auto* reply = std::get_if<Reply>(&entry)) {
      frame_.add(*reply);
    } else {
      const auto& [set, since] = std::get<TimedSet>(entry);
      auto remaining = set;
      remaining.time_to_live -= now - since;
      if (set.time_to_live == Duration(0) || remaining.time_to_live > Duration(0)) frame_.add(remaining);
    }
  }
  return count;
}

bool Channel::write() {
  rubicon_wire_Frame frame{};
  frame.source = number(ends_.source);
  frame.source_incarnation = ends_.source_incarnation;
  frame.target_incarnation = ends_.target_incarnation;
  const auto bytes = frame_.view();
  frame.content._maximum = frame.content._length = static_cast<std::uint32_t>(bytes.size());
  frame.content._buffer = const_cast<std::uint8_t*>(bytes.data());  // DDS only reads it
  return dds_write(writer_.get(), &frame) == DDS_RETCODE_OK;
}

Channel::State Channel::flush(SteadyTime now, const Times& times) {
  if (entries_.empty() && !times_due_) return State::kEmpty;
  if (!has_readers()) return State::kFull;
  for (int frames = 0; frames < kFramesPerTurn; ++frames) {
    const auto count = fill(now, times);
    if (frame_.size() > 0 && !write()) return State::kFull;
    times_due_ = asks_ = false;
    for (std::size_t i = 0; i < count; ++i) {
      waiting_ -= entries_.front().second;
      entries_.pop_front();
    }
    if (entries_.empty()) return State::kEmpty;
  }
  return State::kMore;
}

}  // namespace rubicon::tuples::dds
