#include "tuples/outbox.h"

#include <algorithm>

namespace rubicon::tuples {

void Outbox::mark(PeerBox& box, std::uint32_t index) {
  if (box.gone) return;
  if (box.marked.size() <= index) box.marked.resize(std::max<std::size_t>(index + 1, box.marked.size() * 2));
  if (box.marked[index]) {
    ++merged_;
    return;
  }
  if (box.waiting.size() >= kMaxWaiting) {
    ++dropped_;
    return;
  }
  box.marked[index] = true;
  box.waiting.push_back({index, 0});
  store_.pool().pin(index);
  list(box);
}

void Outbox::mark_snapshot_end(PeerBox& box, std::uint32_t subscription) {
  if (box.gone) return;
  box.waiting.push_back({kNone, subscription});
  list(box);
}

void Outbox::list(PeerBox& box) {
  ++size_;
  if (std::exchange(box.listed, true)) return;
  listed_.push_back(&box);
}

Outbox::Left Outbox::flush() {
  auto left = Left::kNothing;
  for (std::size_t i = 0; i < listed_.size(); ++i) left = std::max(left, flush(*listed_[i]));
  std::erase_if(listed_, [](PeerBox* box) {
    box->listed = !box->waiting.empty();
    return !box->listed;
  });
  return left;
}

Outbox::Left Outbox::flush(PeerBox& box) {
  std::size_t done = 0;
  auto left = Left::kNothing;
  for (std::size_t frame = 0; done < box.waiting.size(); ++frame) {
    const auto count = fill_frame(box, done);
    left = frame == kFramesPerTurn ? Left::kMore : link_.publish(box.id, frame_) ? Left::kNothing : Left::kNoRoom;
    if (left != Left::kNothing) break;
    sent(box, done, count);
    done += count;
  }
  box.waiting.erase(box.waiting.begin(), box.waiting.begin() + static_cast<std::ptrdiff_t>(done));
  if (box.waiting.empty() && box.waiting.capacity() > 65536) box.waiting.shrink_to_fit();
  return left;
}

std::size_t Outbox::fill_frame(const PeerBox& box, std::size_t from) {
  frame_.clear();
  std::size_t bytes = 0;
  for (auto at = from; at < box.waiting.size() && frame_.size() < kFrameChanges && bytes < kFrameBytes; ++at) {
    const auto [index, snapshot_of] = box.waiting[at];
    Change change;
    if (index == kNone) {
      change.tuple.sequence = snapshot_of;
    } else {
      const auto& tuple = store_.at(index);
      change.kind = tuple.present ? EventKind::kSet : tuple.end;
      change.tuple = store_.view(index);
    }
    bytes += change.tuple.key.size() + change.tuple.value.size();
    frame_.push_back(change);
  }
  return frame_.size();
}

void Outbox::sent(PeerBox& box, std::size_t from, std::size_t count) {
  size_ -= count;
  for (auto at = from; at < from + count; ++at) {
    const auto index = box.waiting[at].tuple;
    if (index == kNone) continue;
    box.marked[index] = false;
    store_.pool().unpin(index);
  }
}

void Outbox::forget(PeerBox& box) {
  box.gone = true;
  sent(box, 0, box.waiting.size());
  box.waiting.clear();
  if (std::exchange(box.listed, false)) std::erase(listed_, &box);
}

}  // namespace rubicon::tuples
