#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "tuples/peis/troubles.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// The last ids that came, to drop what comes again. Bounded: the oldest is forgotten first. Ids are below the greatest
/// that there is.
template <std::unsigned_integral Id>
class SeenIds {
 public:
  explicit SeenIds(std::size_t capacity) : capacity_(capacity) {}

  /// False: it was here.
  bool add(Id number) {
    const Id id = number + 1;
    if (2 * (ring_.size() + (ring_.size() < capacity_ ? 1 : 0)) > slots_.size()) grow();
    auto at = place_of(id);
    if (slots_[at] == id) return false;
    if (ring_.size() < capacity_) {
      ring_.push_back(id);
    } else {
      erase(std::exchange(ring_[oldest_], id));
      oldest_ = (oldest_ + 1) % capacity_;
      at = place_of(id);
    }
    slots_[at] = id;
    return true;
  }
  /// Remembers more from now on, and forgets none.
  void widen(std::size_t capacity) {
    std::rotate(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(oldest_), ring_.end());
    oldest_ = 0;
    capacity_ = std::max(capacity_, capacity);
  }
  bool contains(Id number) const { return !slots_.empty() && slots_[place_of(number + 1)] == number + 1; }
  std::size_t size() const { return ring_.size(); }

 private:
  static constexpr std::size_t kMinCount = 64;

  // Below, ids are one more, so that 0 is a free slot.

  std::size_t home_of(Id id) const { return (std::uint64_t{id} * 0x9e3779b97f4a7c15U) >> shift_; }
  std::size_t next(std::size_t at) const { return (at + 1) & (slots_.size() - 1); }
  /// Where the id is, or else belongs.
  std::size_t place_of(Id id) const {
    auto at = home_of(id);
    while (slots_[at] != 0 && slots_[at] != id) at = next(at);
    return at;
  }
  /// Closes the gap: each id stays reachable from its home.
  void erase(Id id) {
    auto gap = place_of(id);
    const auto mask = slots_.size() - 1;
    for (auto at = next(gap); slots_[at] != 0; at = next(at)) {
      if (((at - home_of(slots_[at])) & mask) < ((at - gap) & mask)) continue;
      slots_[gap] = slots_[at];
      gap = at;
    }
    slots_[gap] = 0;
  }
  void grow() {
    slots_.assign(std::max(kMinCount, 2 * slots_.size()), 0);
    shift_ = 64 - std::countr_zero(slots_.size());
    for (const auto id : ring_) slots_[place_of(id)] = id;
  }

  std::size_t capacity_;
  std::vector<Id> slots_;  ///< a power of two, at most half full; 0 = free
  int shift_ = 0;          ///< of the hash, to an index of the slots
  std::vector<Id> ring_;
  std::size_t oldest_ = 0;
};

/// How a message to a host ended.
enum class Outcome {
  kDelivered,  ///< the host acknowledged all of it; a G6 kernel does not say whether it accepted it
  kGivenUp,    ///< not acknowledged after 7 resends (11.6 s); it may have arrived
  kHostGone,   ///< the host left or was lost; it may have arrived
  kNotSent,    ///< its time was over before there was room for it
};
/// Not called if the node is destroyed first.
using Done = std::function<void(Outcome)>;

/// What became of a package on its way out.
enum class Emitted { kSent, kFull, kNoRoute };

/// What one host may have of us: packages between the oldest unacknowledged and the newest one, and bytes of messages
/// that wait before them (one message may be longer).
struct SendWindow {
  std::size_t packages = 0, waiting = 0;
};

/// The acknowledged messages of a node: windows, resends, outcomes; and the acknowledgements and duplicates of what it
/// receives (peis.md, section 3.6). Knows no links.
class Deliveries {
 public:
  struct Callbacks {
    /// Hands a whole package to the link towards a host. It may change the package id and the counter only.
    std::function<Emitted(OwnerId to, std::span<std::uint8_t> package, bool urgent)> emit;
    /// There is room after send() gave kBusy.
    std::function<void(OwnerId to)> ready;
  };
  static constexpr SendWindow kOfKernel{400, 64 * 1024};  ///< section 6.2, 14
  static constexpr SendWindow kOfOurs{4096, 1024 * 1024};
  /// A kernel reads one package in each step of its program: 880/s as shipped. Further packages wait in its socket, and
  /// after 0.4 s they are sent again in vain. So the window of a kernel follows how soon it acknowledges.
  static constexpr std::size_t kFirstOfKernel = 128, kMinOfKernel = 32;
  static constexpr Duration kLateAck = std::chrono::milliseconds(300);      ///< a kernel collects acks for 0.2 s
  static constexpr std::size_t kMaxBytes = std::size_t{256} * 1024 * 1024;  ///< of all hosts
  static constexpr std::size_t kMaxLength = std::size_t{16} * 1024 * 1024;  ///< of a message

  /// Package and ack ids count from `seed` on. The counters must outlive it.
  Deliveries(Scheduler& scheduler, OwnerId self, std::uint32_t seed, NodeCounters& counters, Callbacks calls);

  void open(OwnerId host, bool is_ours);
  bool is_open(OwnerId host) const { return peers_.contains(host); }
  /// The host is a component of ours: its window becomes wider.
  void widen(OwnerId host);
  /// The host is gone: its messages end with kHostGone.
  void close(OwnerId host);

  /// As Node::send().
  Result<void> send(OwnerId to, Port port, ByteView body, Done done);
  void acknowledged(OwnerId from, const Acks& acks);
  /// The route to the host is new: sends all that is not acknowledged once more, in order.
  void send_again(OwnerId to);
  /// There is room on a link.
  void pump();
  std::size_t unacknowledged(OwnerId to) const;

  /// Has the package acknowledged within 0.2 s.
  void acknowledge(OwnerId source, std::uint32_t ack_id);
  /// Whether a package with this ack id is the first one of its source.
  bool is_new(OwnerId source, std::uint32_t ack_id);

  /// Of a package that is sent once, without acknowledgement.
  PackageHeader next_header(Routing routing, Port port, OwnerId destination);

 private:
  /// A message with an outcome, or in several packages.
  struct Message {
    Done done;
    std::size_t missing = 0;  ///< packages without an acknowledgement
    bool ended = false;
  };
  using MessagePtr = std::shared_ptr<Message>;
  struct Waiting {
    Port port{};
    Bytes body;
    MessagePtr message;
    std::uint16_t fragments = 1, next = 0, number = 0;
  };
  struct Sent {
    std::uint32_t ack_id = 0;
    Bytes package;
    MessagePtr message;
    SteadyTime due{};
    int resends = 0;
    bool over = false;
  };
  struct Peer {
    explicit Peer(bool ours)
        : window(ours ? kOfOurs : kOfKernel),
          packages(ours ? kOfOurs.packages : kFirstOfKernel),
          is_wide(ours),
          seen(ours ? kSeenOfOurs : kDuplicateTable) {}
    SendWindow window;
    std::size_t packages;     ///< of the window, at present
    std::size_t settled = 0;  ///< in time since `packages` grew
    SteadyTime next_cut{};    ///< when `packages` may shrink again
    std::deque<Waiting> waiting;
    std::size_t waiting_bytes = 0;
    std::deque<Sent> sent;
    std::uint64_t first = 0;         ///< serial number of sent.front()
    std::uint64_t to_emit = 0;       ///< serial number of the first package that no link took
    std::size_t unacknowledged = 0;  ///< of those sent
    std::uint64_t next_ack = 0;      ///< serial number behind that of the last acknowledged package
    std::uint16_t last_long = 0;
    bool refused = false;  ///< send() gave kBusy
    std::vector<std::uint32_t> acks;
    bool is_wide;
    SeenIds<std::uint32_t> seen;
  };
  struct Ended {
    MessagePtr message;
    Outcome outcome;
  };
  static constexpr std::size_t kSeenOfOurs = 2 * kOfOurs.packages;
  static constexpr std::size_t kMaxSpare = 512, kMaxSpareBytes = 1024;  ///< buffers that are kept; bytes of each

  std::uint32_t next_id() { return last_id_ = last_id_ >= kMaxId ? 1 : last_id_ + 1; }
  bool has_room(const Peer& peer) const { return peer.sent.size() < peer.packages; }
  void enqueue(OwnerId to, Peer& peer, Port port, ByteView body, MessagePtr message, std::uint16_t number,
               std::uint16_t fragments, std::uint16_t index);
  void fill(OwnerId to, Peer& peer);
  void emit(OwnerId to, Peer& peer);
  void advance(OwnerId to, Peer& peer);
  static bool is_late(const Sent& sent, SteadyTime now);
  void adapt(Peer& peer, std::size_t settled, bool late);
  static Sent* find(Peer& peer, std::uint32_t ack_id);
  void settle(Peer& peer, Sent& sent);
  void end(const MessagePtr& message, Outcome outcome);
  void drop_rest(Peer& peer, const MessagePtr& message);
  void resend_due();
  SteadyTime resend(OwnerId to, Peer& peer, SteadyTime now);
  void flush(OwnerId source, Peer& peer);
  void flush_all();
  void report();

  Scheduler& scheduler_;
  OwnerId self_;
  std::uint32_t last_id_;
  NodeCounters& counters_;
  Callbacks callbacks_;
  std::map<OwnerId, Peer> peers_;
  std::size_t bytes_ = 0;     ///< of all packages and waiting messages
  std::vector<Bytes> spare_;  ///< buffers of packages that are over
  std::vector<Ended> ended_;
  std::vector<OwnerId> ready_;
  base::Deadline resends_, acks_;
};

}  // namespace rubicon::tuples::peis
