#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "base/deadline.h"
#include "tuples/peis/counters.h"
#include "tuples/peis/seen_ids.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

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
  struct Calls {
    /// Hands a whole package to the link towards a host. It may change the package id and the counter only.
    std::function<Emitted(OwnerId to, std::span<std::uint8_t> package, bool urgent)> emit;
    /// There is room after send() gave kBusy.
    std::function<void(OwnerId to)> ready;
  };
  static constexpr SendWindow kOfKernel{400, 64 * 1024};  ///< section 6.2, 14
  static constexpr SendWindow kOfOurs{4096, 1024 * 1024};
  /// A kernel takes in as many packages as its program makes steps, 880/s as shipped. More of them only get old in its
  /// socket, and are sent again in vain from 0.4 s on. So its window follows the time of its acknowledgements.
  static constexpr std::size_t kFirstOfKernel = 128, kLeastOfKernel = 32;
  static constexpr Duration kLateAck = std::chrono::milliseconds(300);      ///< a kernel collects acks for 0.2 s
  static constexpr std::size_t kMaxBytes = std::size_t{256} * 1024 * 1024;  ///< of all hosts
  static constexpr std::size_t kLongest = std::size_t{16} * 1024 * 1024;    ///< of a message

  /// Package and ack ids count from `seed` on. The counters must outlive it.
  Deliveries(Scheduler& scheduler, OwnerId self, std::uint32_t seed, Counters& counters, Calls calls);

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

  std::uint32_t next_id() { return last_id_ = last_id_ >= kMaxId ? 1 : last_id_ + 1; }

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
    SeenIds seen;
  };
  struct Ended {
    MessagePtr message;
    Outcome outcome;
  };
  static constexpr std::size_t kSeenOfOurs = 2 * kOfOurs.packages;
  static constexpr std::size_t kMaxSpare = 512;

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
  Counters& counters_;
  Calls calls_;
  std::map<OwnerId, Peer> peers_;
  std::size_t bytes_ = 0;     ///< of all packages and waiting messages
  std::vector<Bytes> spare_;  ///< buffers of packages that are over
  std::vector<Ended> ended_;
  std::vector<OwnerId> ready_;
  base::Deadline resends_, acks_;
};

}  // namespace rubicon::tuples::peis
