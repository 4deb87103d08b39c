#pragma once

#include <array>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "rubicon/time.hpp"
#include "tuples/peis/kernel_state.h"
#include "tuples/peis/node.h"
#include "tuples/peis/session.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

/// Set to anything but empty, `no` and `nil` it ends a kernel (peis.md, section 1.11); never a component of ours.
inline constexpr std::string_view kQuitKey = "kernel.do-quit";

/// The tuples that each component publishes about itself (peis.md, section 1.11). Kernels alone see them.
class KernelTuples {
 public:
  struct Tuple {
    std::string value;
    std::uint32_t number = 0;
    WallTime written{};
  };

  /// Their keys, as in kernel.all-keys.
  static constexpr std::string_view kNames =
      "kernel.id kernel.name kernel.hostname kernel.user kernel.version kernel.do-quit kernel.all-keys "
      "kernel.subscribers kernel.traffic kernel.step-time kernel.connections kernel.routingTable";

  /// Whether the key, in any case, is one of these.
  static bool owns(std::string_view key);

  /// Sets a tuple; false: it had that value.
  bool set(std::string_view key, std::string value, WallTime now);
  const std::map<std::string, Tuple, std::less<>>& all() const { return tuples_; }

 private:
  std::map<std::string, Tuple, std::less<>> tuples_;
};

/// PUSH_TUPLE of one of them.
Bytes write_kernel_tuple(OwnerId self, std::string_view key, const KernelTuples::Tuple& tuple);

// Values of the tuples.

/// `((<peer> <bytes/s in> <bytes/s out> <type> <loss>)...)`: rates since `before`, over `span`.
std::string connections_text(const std::vector<LinkState>& links, const std::vector<LinkState>& before, Duration span);
/// `(<bytes/s in> <bytes/s out>)`
std::string traffic_text(const std::vector<LinkState>& links, const std::vector<LinkState>& before, Duration span);
/// `(\n (<id> <hops> <via>)\n)\n`
std::string routing_text(const std::vector<RouteState>& routes);

/// With a PEIS kernel of 2013, or any other program that speaks its protocol. What the protocol cannot carry is refused
/// or stated: README.md of this folder.
class KernelSession final : public Session {
 public:
  /// What all kernels see of this component.
  struct View {
    OwnKeys keys;
    KernelTuples tuples;
  };
  KernelSession(SessionContext& context, OwnerId peer, View& view);

  void publish(const Change& change) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  void describe(const std::string&) override {}  // they have kernel.* tuples
  void receive(Port port, ByteView body) override;
  void forgotten() override;
  void back() override;
  void ended() override;
  std::vector<std::string> patterns() const override;

  /// There is an own tuple with this key.
  void key_added(const std::string& key);
  /// Sends one of KernelTuples if the kernel subscribed to it, as soon as there is room.
  void push_kernel_tuple(const std::string& key);

 private:
  static constexpr std::size_t kMaxRequested = 10'000;
  static constexpr std::size_t kMaxAppended = 1'000;  ///< tuples that one append may change
  static constexpr std::size_t kMaxLostDeletes = 10'000;
  static constexpr std::size_t kMaxAsked = 10'000;         ///< requests of the kernel without a reply
  static constexpr std::size_t kMaxNamedRefusals = 16;     ///< lines in kRefusalsEach
  static constexpr std::size_t kMaxMoreRefusals = 10'000;  ///< counted besides
  static constexpr Duration kRefusalsEach = std::chrono::minutes(1);
  static constexpr Duration kRequestAgain = std::chrono::seconds(10);  ///< what was given up

  enum class Request { kDue, kSent, kAcknowledged, kGivenUp };
  struct Subscription {
    SubscriptionSpec spec;
    std::vector<std::string> patterns;  ///< of the kernel, folded
    bool waits = true;                  ///< for the end of its snapshot
  };
  struct PendingSet {
    std::uint64_t request = 0;
    std::string key;  ///< folded
    std::string value;
  };

  struct Asked {
    std::string key;
    bool append = false;
  };

  /// What a push deleted, if it did.
  struct Deleted {
    std::string key;
    std::uint32_t number = 0;
  };

  // Own tuples (kernel_session_values.cpp).
  void publish(const TupleSet& set);
  void publish(const TupleGone& gone);
  void publish(const SnapshotEnd& end);
  void publish(const Restart&) {}  // kernels go by numbers
  bool is_publishable(std::string_view key);
  void push_gone(const std::string& key, std::uint32_t number);
  Done watched(const Deleted& deleted);
  void lost(const Deleted& deleted);
  void push_again();

  // Their tuples (kernel_session_values.cpp).
  void on_push(ByteView body);
  void on_delete(const NetworkTuple& tuple);
  void on_appended(ByteView body);
  void deliver_copy(const KernelCopies::Copy& copy);
  void not_kept(std::uint64_t values);
  void expire_copies();
  std::string_view own_spelling(std::string_view key) const;

  // Our subscriptions and theirs (kernel_session_subscriptions.cpp).
  void request(const std::string& pattern, bool force);
  bool send_next() override;
  void send_request(const std::string& pattern, bool force);
  void requested(const std::string& pattern, Outcome outcome);
  void request_again();
  bool is_acknowledged(const Subscription& subscription) const;
  void settle(std::uint32_t id);
  void forget_patterns(std::uint32_t id, const std::vector<std::string>& patterns);
  void on_subscribe(ByteView body);
  void on_unsubscribe(ByteView body);
  void join(std::uint32_t id);

  // Remote sets, both ways (kernel_session_sets.cpp).
  Result<void> check(const RemoteSet& set) const;
  Bytes encode(const RemoteSet& set) const;
  Bytes encode_append(const RemoteSet& set) const;
  void arrived(std::uint64_t request, Outcome outcome);
  void saw(const KernelCopies::Copy& copy);
  void answer(std::uint64_t request, Outcome outcome, std::uint64_t sequence);
  void on_set(ByteView body);
  void on_append(ByteView body);
  void ask_owner(RemoteSet set);
  void refused(std::string_view what, std::string_view key, std::string_view why);
  void tell_more_refusals();
  /// Guarded by the life of this session and of the start.
  Done guarded(std::function<void(Outcome)> call);

  View& view_;
  KernelCopies copies_;
  KernelSubscribers subscribers_;
  std::map<std::uint32_t, Subscription> subscriptions_;
  std::map<std::string, std::set<std::uint32_t>> by_pattern_;  ///< their ids, by folded pattern
  std::map<std::string, std::string> spellings_;               ///< of keys that we subscribed to, by folded key
  std::map<std::string, Request> requests_;                    ///< subscriptions that the kernel has, by folded pattern
  std::map<std::string, bool> due_requests_;                   ///< those of them that wait for room: whether with force
  std::set<std::string> due_tuples_;                           ///< of KernelTuples: their newest values wait for room
  std::map<std::string, std::uint32_t> lost_deletes_;          ///< numbers of deletes that were given up
  bool lost_pushes_ = false;                                   ///< some push was given up: all follow again
  std::deque<PendingSet> sets_;
  std::uint64_t last_set_ = 0;  ///< number of the kernel's remote sets
  std::map<std::uint64_t, Asked> asked_;
  std::set<std::string> named_refusals_, more_refusals_;  ///< "set KEY": with a line, without
  base::Deadline again_, expiry_, refusals_due_;
};

}  // namespace rubicon::tuples::peis
