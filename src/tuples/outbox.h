#pragma once

#include <memory>
#include <vector>

#include "tuples/store.h"

namespace rubicon::tuples {

/// What one distant subscriber has not been sent yet: tuples, each at most once, and ends of snapshots, in order.
struct PeerBox {
  struct Waiting {
    std::uint32_t tuple = kNone;
    std::uint32_t snapshot_of = 0;  ///< subscription id, when tuple is none
  };
  OwnerId id{};
  bool gone = false;
  bool listed = false;  ///< among the boxes that have something
  std::vector<Waiting> waiting;
  std::vector<bool> marked;  ///< by tuple index
};

/// Hands the latest values to the link, per subscriber and turn; keeps what the link does not take.
class Outbox {
 public:
  static constexpr std::size_t kFrameChanges = 512;
  static constexpr std::size_t kFrameBytes = 256UL * 1024;
  static constexpr std::size_t kFramesPerTurn = 16;
  static constexpr std::size_t kMaxWaiting = 4'000'000;

  enum class Left { kNothing, kMore, kNoRoom };

  Outbox(Store& store, Link& link) : store_(store), link_(link) {}

  void mark(PeerBox& box, std::uint32_t index);
  void mark_snapshot_end(PeerBox& box, std::uint32_t subscription);
  /// Only into an empty box: what the subscriber has may be old.
  void mark_beginning(PeerBox& box) { mark_snapshot_end(box, 0); }
  /// kMore: go on next turn. kNoRoom: the link refused, try again a little later.
  Left flush();
  void forget(PeerBox& box);

  std::size_t size() const { return size_; }
  bool empty() const { return listed_.empty(); }
  std::uint64_t merged() const { return merged_; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  void list(PeerBox& box);
  Left flush(PeerBox& box);
  std::size_t fill_frame(const PeerBox& box, std::size_t from);
  void sent(PeerBox& box, std::size_t from, std::size_t count);

  Store& store_;
  Link& link_;
  std::vector<PeerBox*> listed_;
  std::vector<Change> frame_;
  std::size_t size_ = 0;
  std::uint64_t merged_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace rubicon::tuples
