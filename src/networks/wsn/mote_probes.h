#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <set>

#include "networks/wsn/outgoing.h"

namespace rubicon::networks::wsn {

/// Asks motes whether they are there, a few at a time, so that a restart with many of them keeps the radio free. One
/// that does not answer is asked again when all others were: of 200 motes that were rebooted at once most may be lost
/// to the sink for good (wsn.md 9.2), and the rest is not to wait for them.
class MoteProbes {
 public:
  static constexpr std::size_t kAtATime = 8;
  static constexpr unsigned kAttempts = 3;
  using DoneCall = std::function<void(Delivered)>;

  MoteProbes(std::uint16_t island, MoteRequests& requests) : island_(island), requests_(requests) {}

  /// A mote that waits or is being asked is not asked twice: then `done` is not called, and the result is false. One
  /// that did not answer and waits to be asked again is asked as if for the first time; who asked before hears so.
  bool ask(std::uint16_t mote, DoneCall done);
  std::uint64_t asked() const { return asked_; }
  std::size_t waiting() const { return waiting_.size() + silent_.size(); }

 private:
  struct Question {
    std::uint16_t mote = 0;
    DoneCall done;
    unsigned attempts = 0;
  };
  void next();
  bool put(Question question);
  void ended(Question question, Delivered how);
  bool give_up_silent(std::uint16_t mote);

  std::uint16_t island_;
  MoteRequests& requests_;
  std::deque<Question> waiting_;
  std::deque<Question> silent_;    ///< did not answer so far
  std::set<std::uint16_t> known_;  ///< waiting or being asked
  std::size_t under_way_ = 0;
  std::uint64_t asked_ = 0;
};

}  // namespace rubicon::networks::wsn
