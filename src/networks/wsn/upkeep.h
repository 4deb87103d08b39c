#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "base/scheduler.h"
#include "networks/wsn/outgoing.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn {

/// Probes motes for a sign of life, few at a time, so that a restart with many of them does not congest the radio. A
/// mote that does not answer is probed again after all others. One that did not answer its last probe either is lost:
/// lost motes wait in a queue with slots of its own, and are probed at growing intervals. After a power failure most of
/// 200 motes may be lost to the sink for good (wsn.md 9.2); the others do not wait for them.
class MoteProbes {
 public:
  static constexpr std::size_t kMaxConcurrent = 24;
  static constexpr std::size_t kMaxConcurrentLost = 2;  ///< in addition
  static constexpr unsigned kAttempts = 3;              ///< 1 for lost motes
  /// From an unanswered probe of a lost mote to the next one; doubles with each in a row.
  static constexpr Duration kFirstPause = std::chrono::seconds(10);
  static constexpr Duration kMaxPause = std::chrono::minutes(2);
  using DoneCallback = std::function<void(DeliveryResult)>;

  MoteProbes(std::uint16_t island, Scheduler& scheduler, MoteRequests& requests)
      : island_(island), scheduler_(scheduler), requests_(requests) {}

  /// kDuplicate: a probe of the mote is pending. kBusy: the mote is lost, and its pause is not over. After an error
  /// `done` is not called.
  Result<void> probe(std::uint16_t mote, DoneCallback done);
  /// The mote gave a sign of life.
  void heard(std::uint16_t mote) { lost_.erase(mote); }
  /// The sink was away, so that no mote could have answered: none counts as lost.
  void forget_lost() { lost_.clear(); }

  /// Probes sent.
  std::uint64_t sent() const { return sent_; }
  std::size_t waiting() const { return waiting_.size() + silent_.size() + lost_waiting_.size(); }
  std::size_t lost() const { return lost_.size(); }

 private:
  struct Probe {
    std::uint16_t mote = 0;
    DoneCallback done;
    unsigned attempts = 0;
    bool lost = false;
  };
  struct Lost {
    SteadyTime due{};
    Duration pause{};
  };
  void next();
  void start_first(std::deque<Probe>& queue);
  bool start(Probe probe);
  void ended(Probe probe, DeliveryResult result);

  std::uint16_t island_;
  Scheduler& scheduler_;
  MoteRequests& requests_;
  std::deque<Probe> waiting_;
  std::deque<Probe> silent_;  ///< not answered so far
  std::deque<Probe> lost_waiting_;
  std::set<std::uint16_t> pending_;     ///< motes whose probe waits or is under way
  std::map<std::uint16_t, Lost> lost_;  ///< motes that did not answer their last probe
  std::size_t under_way_ = 0, lost_under_way_ = 0;
  std::uint64_t sent_ = 0;
};

/// Keeps the id of our island set in a sink: after a power cycle a sink has its compiled-in id again, and does not
/// report it (wsn.md 9.1).
class IslandIdKeeper {
 public:
  using SendCall = std::function<Result<void>(sink::Outgoing)>;
  /// Minimum time between two corrections.
  static constexpr Duration kMinPause = std::chrono::seconds(5);

  IslandIdKeeper(std::uint16_t island, Scheduler& scheduler, SendCall send)
      : island_(island), scheduler_(scheduler), send_(std::move(send)) {}

  /// The SET_ISLAND_ID packet; also the first packet after each opening of the line.
  Bytes packet() const;
  /// Sends the id periodically from now on; nullopt: not any longer.
  void repeat(std::optional<Duration> period);
  bool repeats() const { return next_.pending(); }
  /// Sends the id now, because the sink seems to have another one; does nothing within kMinPause of the last call.
  void correct();

 private:
  std::uint16_t island_;
  Scheduler& scheduler_;
  SendCall send_;
  std::optional<SteadyTime> corrected_;
  Timer next_;
};

}  // namespace rubicon::networks::wsn
