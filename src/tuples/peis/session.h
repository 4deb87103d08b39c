#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/link.h"
#include "tuples/peis/node.h"
#include "tuples/peis/troubles.h"

namespace rubicon::tuples::peis {

/// What the sessions of one component did not do, and why.
struct SessionCounters {
  std::uint64_t bad_messages = 0;      ///< messages of tuples that cannot be decoded
  std::uint64_t foreign_tuples = 0;    ///< tuples whose owner is not the sender
  std::uint64_t refused_keys = 0;      ///< own tuples that the other cannot have: long keys, keys that differ in case
  std::uint64_t unknown_keys = 0;      ///< tuples of kernels whose keys are none of ours
  std::uint64_t refused_patterns = 0;  ///< subscriptions that cannot be met
  std::uint64_t refused_sets = 0;      ///< remote sets of kernels that were refused, which they do not learn
  std::uint64_t ignored_quits = 0;     ///< remote sets of `kernel.do-quit`
  std::uint64_t dropped_replies = 0;   ///< to components that do not read them
  std::uint64_t copies_not_kept = 0;   ///< tuples of kernels beyond the bounds
  std::uint64_t lost_pushes = 0;       ///< to kernels that did not acknowledge them: made again later
};

/// What the sessions of one start of a component share. The sessions do not outlive it.
struct SessionContext {
  OwnerId self{};
  Scheduler& scheduler;
  base::LimitedLog& log;
  LinkListener* listener = nullptr;  ///< null: the start is over
  Node* node = nullptr;
  int calls = 0;  ///< to the listener that are under way: the start must not be destroyed
  SessionCounters counters{};
};

/// The state that a component shares with another one while that is up: tuples, subscriptions and requests, in both
/// directions. There is one class for components of ours and one for kernels.
class Session {
 public:
  /// Remote sets and replies beyond it are refused; publications wait for less (is_full()).
  static constexpr std::size_t kMaxWaiting = 32 * 1024 * 1024;

  Session(SessionContext& context, OwnerId peer) : context_(context), peer_(peer) {}
  virtual ~Session() = default;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // As in Link; subscriptions are for this peer.
  virtual void publish(const Change& change) = 0;
  virtual void subscribe(const SubscriptionSpec& spec) = 0;
  virtual void unsubscribe(std::uint32_t id) = 0;
  virtual Result<void> remote_set(const RemoteSet& set) = 0;
  virtual void reply(const Reply& reply) = 0;
  virtual void describe(const std::string& summary) = 0;

  /// A message of the peer.
  virtual void receive(Port port, ByteView body) = 0;
  /// The peer deleted what it knew of this component. All subscriptions follow, and the summary.
  virtual void forgotten() = 0;
  /// The peer is gone: the last call.
  virtual void ended() {}
  /// The peer is routable again; what was sent meanwhile may be lost. All subscriptions follow, and the summary.
  virtual void back() = 0;

  /// The patterns that the peer subscribed to.
  virtual std::vector<std::string> patterns() const = 0;

  /// There is room again.
  void ready();
  /// Whether messages wait for room: publications should wait too.
  bool is_full() const { return !waiting_.empty(); }

 protected:
  /// Sends a message, after those that wait. After `ends` it is not sent any more: kNotSent.
  void send(Port port, ByteView body, Done done = {}, SteadyTime ends = SteadyTime::max());
  bool has_room(std::size_t bytes) const { return waiting_bytes_ + bytes <= kMaxWaiting; }
  /// Sends what is due while there is room.
  void send_due();
  /// Sends one of the things that are due: wishes that replace each other while they wait. False: there is none.
  virtual bool send_next() { return false; }
  /// Called before a message that had to wait is sent.
  virtual void restamp(Bytes& body, Duration remaining);
  /// Makes calls to the listener, which may end the link: the start, and this, then live until the last one is over.
  template <class Call>
  void during(Call call) {
    if (!context_.listener) return;
    auto& context = context_;
    ++context.calls;
    call();
    --context.calls;
  }
  /// The same in a later turn, unless this is destroyed by then.
  template <class Call>
  void later(Call call) {
    lifetime_.post(context_.scheduler, [this, call = std::move(call)] { during(call); });
  }
  void deliver(const Change& change);
  /// In a later turn.
  void end_snapshot(std::uint32_t subscription);
  void bad(const Error& error);
  /// `component 7`, for log lines.
  std::string name() const;

  SessionContext& context_;
  OwnerId peer_;
  base::Lifetime lifetime_;

 private:
  struct Waiting {
    Port port{};
    Bytes body;
    Done done;
    SteadyTime ends{};
  };

  bool try_send(Port port, ByteView body, const Done& done);

  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
};

/// Calls `visit` with the name (`refused-keys`) and the value of each counter.
using CounterVisit = std::function<void(std::string_view name, std::uint64_t value)>;
void each_counter(const NodeCounters& counters, const CounterVisit& visit);
void each_counter(const SessionCounters& counters, const CounterVisit& visit);

}  // namespace rubicon::tuples::peis
