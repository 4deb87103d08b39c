#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <set>

#include "networks/wsn/outgoing.h"

namespace rubicon::networks::wsn {

/// Asks motes whether they are there, some at a time, so that a restart with many of them keeps the radio free. One
/// that does not answer is asked again when all others were. One that did not answer its last question either is lost:
/// it stands in a queue of its own, with a few places that nobody else has, and is asked ever less often. So of 200
/// motes that were rebooted at once, most of them lost to the sink for good (wsn.md 9.2), the living ones never wait
/// for the rest.
class MoteProbes {
 public:
  static constexpr std::size_t kAtATime = 24;
  static constexpr std::size_t kLostAtATime = 2;  ///< besides those
  static constexpr unsigned kAttempts = 3;        ///< 1 for lost ones
  /// From an unanswered question to the next one, doubled with each in a row.
  static constexpr Duration kFirstPause = std::chrono::seconds(10);
  static constexpr Duration kLongestPause = std::chrono::minutes(2);
  using DoneCall = std::function<void(DeliveryResult)>;

  MoteProbes(std::uint16_t island, Scheduler& scheduler, MoteRequests& requests)
      : island_(island), scheduler_(scheduler), requests_(requests) {}

  /// kDuplicate: it waits to be asked (again) or is being asked. kBusy: it is lost, and not due yet. Then `done` is not
  /// called.
  Result<void> ask(std::uint16_t mote, DoneCall done);
  /// It gave a sign of life.
  void heard(std::uint16_t mote) { lost_.erase(mote); }
  /// Nobody could have answered: the sink was away.
  void forgive() { lost_.clear(); }

  std::uint64_t asked() const { return asked_; }
  std::size_t waiting() const { return waiting_.size() + silent_.size() + lost_waiting_.size(); }
  std::size_t lost() const { return lost_.size(); }

 private:
  struct Question {
    std::uint16_t mote = 0;
    DoneCall done;
    unsigned attempts = 0;
    bool lost = false;
  };
  struct Lost {
    SteadyTime due{};
    Duration pause{};
  };
  void next();
  void take_from(std::deque<Question>& queue);
  bool put(Question question);
  void ended(Question question, DeliveryResult how);

  std::uint16_t island_;
  Scheduler& scheduler_;
  MoteRequests& requests_;
  std::deque<Question> waiting_;
  std::deque<Question> silent_;  ///< did not answer so far
  std::deque<Question> lost_waiting_;
  std::set<std::uint16_t> known_;       ///< waiting or being asked
  std::map<std::uint16_t, Lost> lost_;  ///< did not answer their last question
  std::size_t under_way_ = 0, lost_under_way_ = 0;
  std::uint64_t asked_ = 0;
};

}  // namespace rubicon::networks::wsn
