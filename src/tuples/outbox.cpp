#include "tuples/outbox.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples {

void Outbox::add(PeerQueue& peer, std::uint32_t index) {
  if (peer.closed) return;
  if (!peer.withdrawn.empty()) peer.withdrawn.erase(index);
  if (peer.queued.size() <= index) peer.queued.resize(std::max<std::size_t>(index + 1, peer.queued.size() * 2));
  if (peer.queued[index]) {
    ++merged_;
    return;
  }
  if (peer.entries.size() >= most_) {
    ++dropped_;
    return;
  }
  peer.queued[index] = true;
  peer.entries.emplace_back(PeerQueue::TupleIndex(index));
  store_.pool().pin(index);
  list(peer);
}

bool Outbox::withdraw(PeerQueue& peer, std::uint32_t index) {
  if (peer.closed) return true;
  add(peer, index);
  if (!peer.queued[index]) return std::exchange(peer.broken, true);
  peer.withdrawn.insert(index);
  return true;
}

void Outbox::add_control(PeerQueue& peer, const PeerQueue::Entry& entry) {
  if (peer.closed) return;
  if (peer.controls >= kMaxControls) drop_needless_ends(peer);
  peer.entries.push_back(entry);
  ++peer.controls;
  list(peer);
}

void Outbox::drop_needless_ends(PeerQueue& peer) {
  std::unordered_set<std::uint32_t> seen;
  const auto is_needless = [&](const PeerQueue::Entry& entry) {
    const auto* end = std::get_if<SnapshotEnd>(&entry);
    return end && !(has_(peer, end->subscription) && seen.insert(end->subscription).second);
  };
  // From the back, because the last end of a subscription is the one that counts.
  const auto first = std::remove_if(peer.entries.rbegin(), peer.entries.rend(), is_needless).base();
  const auto dropped = static_cast<std::size_t>(first - peer.entries.begin());
  peer.entries.erase(peer.entries.begin(), first);
  peer.controls -= dropped;
  size_ -= dropped;
  merged_ += dropped;
}

void Outbox::list(PeerQueue& peer) {
  ++size_;
  if (std::exchange(peer.listed, true)) return;
  listed_.push_back(&peer);
}

Outbox::State Outbox::flush() {
  auto state = State::kEmpty;
  for (std::size_t i = 0; i < listed_.size(); ++i) state = std::max(state, flush(*listed_[i]));
  std::erase_if(listed_, [](PeerQueue* peer) {
    peer->listed = !peer->entries.empty();
    return !peer->listed;
  });
  return state;
}

Outbox::State Outbox::flush(PeerQueue& peer) {
  std::size_t done = 0;
  auto state = State::kEmpty;
  for (std::size_t frame = 0; done < peer.entries.size(); ++frame) {
    const auto count = fill_frame(peer, done);
    state = frame == kFramesPerTurn ? State::kMore : link_.publish(peer.id, frame_) ? State::kEmpty : State::kNoRoom;
    if (state != State::kEmpty) break;
    release(peer, done, count);
    done += count;
  }
  peer.entries.erase(peer.entries.begin(), peer.entries.begin() + static_cast<std::ptrdiff_t>(done));
  if (peer.entries.empty() && peer.entries.capacity() > 4096) peer.entries.shrink_to_fit();
  return state;
}

Change Outbox::change_of(const PeerQueue& peer, const PeerQueue::Entry& entry) const {
  if (const auto* end = std::get_if<SnapshotEnd>(&entry)) return *end;
  if (const auto* restart = std::get_if<Restart>(&entry)) return *restart;
  const auto index = static_cast<std::uint32_t>(std::get<PeerQueue::TupleIndex>(entry));
  const auto& tuple = store_.at(index);
  const bool withdrawn = !peer.withdrawn.empty() && peer.withdrawn.contains(index);
  if (tuple.present && !withdrawn) return TupleSet{store_.view(index)};
  return TupleGone{withdrawn ? EventKind::kDeleted : tuple.end, tuple.key(), tuple.sequence};
}

std::size_t Outbox::fill_frame(const PeerQueue& peer, std::size_t from) {
  frame_.clear();
  std::size_t bytes = 0;
  for (auto at = from; at < peer.entries.size() && frame_.size() < kFrameChanges && bytes < kFrameBytes; ++at) {
    bytes += text_size(frame_.emplace_back(change_of(peer, peer.entries[at])));
  }
  return frame_.size();
}

/// Takes note that these entries leave the queue.
void Outbox::release(PeerQueue& peer, std::size_t from, std::size_t count) {
  size_ -= count;
  for (auto at = from; at < from + count; ++at) {
    const auto* tuple = std::get_if<PeerQueue::TupleIndex>(&peer.entries[at]);
    if (!tuple) {
      --peer.controls;
      continue;
    }
    const auto index = static_cast<std::uint32_t>(*tuple);
    peer.queued[index] = false;
    if (!peer.withdrawn.empty()) peer.withdrawn.erase(index);
    store_.pool().unpin(index);
  }
}

void Outbox::close(PeerQueue& peer) {
  peer.closed = true;
  release(peer, 0, peer.entries.size());
  // Subscriptions that have ended keep the queue for a while, and need no memory of it.
  std::exchange(peer.entries, {});
  std::exchange(peer.queued, {});
  if (std::exchange(peer.listed, false)) std::erase(listed_, &peer);
}

}  // namespace rubicon::tuples
