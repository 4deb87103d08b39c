#pragma once

#include <functional>
#include <memory>
#include <unordered_set>
#include <utility>
#include <variant>
#include <vector>

#include "tuples/link.h"
#include "tuples/store.h"

namespace rubicon::tuples {

/// What has not been sent to one distant subscriber yet, in order: each tuple at most once, and control messages.
struct PeerQueue {
  enum class TupleIndex : std::uint32_t {};
  using Entry = std::variant<TupleIndex, SnapshotEnd, Restart>;

  OwnerId id{};
  bool closed = false;  ///< the subscriber is gone
  bool listed = false;  ///< among the queues of the outbox that are not empty
  bool broken = false;  ///< a withdrawal found no room: the subscriber needs a new beginning
  std::vector<Entry> entries;
  std::size_t controls = 0;                     ///< of the entries: those that are no tuples
  std::vector<bool> queued;                     ///< by tuple index
  std::unordered_set<std::uint32_t> withdrawn;  ///< queued tuples that are taken away from the subscriber
};

/// Passes the latest values to the link, per subscriber and turn; keeps what the link does not accept.
///
/// What waits for a subscriber that reads nothing is bounded. Of tuples there are at most kMaxEntries: values of a
/// tuple that waits are merged, further tuples are dropped. There are at most kMaxControls ends of snapshots. Before
/// one more is added, the ends of subscriptions that the subscriber no longer has are removed, and all but the last end
/// of each subscription. A subscriber has at most half as many subscriptions, so that each of them gets its end.
/// merged() counts those that went.
class Outbox {
 public:
  static constexpr std::size_t kFrameChanges = 512;
  static constexpr std::size_t kFrameBytes = 256UL * 1024;
  static constexpr std::size_t kFramesPerTurn = 16;
  static constexpr std::size_t kMaxEntries = 4'000'000;
  static constexpr std::size_t kMaxControls = 20'000;

  enum class State { kEmpty, kMore, kNoRoom };

  /// Whether the subscriber of the queue has that subscription now.
  using HasSubscription = std::function<bool(const PeerQueue& peer, std::uint32_t subscription)>;

  Outbox(Store& store, Link& link, HasSubscription has) : store_(store), link_(link), has_(std::move(has)) {}

  /// Entries of each queue at most, instead of kMaxEntries.
  void limit(std::size_t most) { most_ = most; }

  void add(PeerQueue& peer, std::uint32_t index);
  /// The subscriber may no longer see the tuple: it receives that the tuple was deleted. False, once for each queue:
  /// there is no room, so that the subscriber would keep its copy; its queue has to be closed and begun again.
  [[nodiscard]] bool withdraw(PeerQueue& peer, std::uint32_t index);
  void add(PeerQueue& peer, const SnapshotEnd& end) { add_control(peer, end); }
  /// To be called while the queue is empty.
  void add(PeerQueue& peer, const Restart& restart) { add_control(peer, restart); }
  /// kMore: continue in the next turn. kNoRoom: the link refused a frame, try again a little later.
  State flush();
  void close(PeerQueue& peer);

  std::size_t size() const { return size_; }
  bool empty() const { return listed_.empty(); }
  std::uint64_t merged() const { return merged_; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  void add_control(PeerQueue& peer, const PeerQueue::Entry& entry);
  void drop_needless_ends(PeerQueue& peer);
  void list(PeerQueue& peer);
  State flush(PeerQueue& peer);
  Change change_of(const PeerQueue& peer, const PeerQueue::Entry& entry) const;
  std::size_t fill_frame(const PeerQueue& peer, std::size_t from);
  void release(PeerQueue& peer, std::size_t from, std::size_t count);

  Store& store_;
  Link& link_;
  HasSubscription has_;
  std::vector<PeerQueue*> listed_;
  std::vector<Change> frame_;
  std::size_t size_ = 0;
  std::size_t most_ = kMaxEntries;
  std::uint64_t merged_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace rubicon::tuples
