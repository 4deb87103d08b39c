#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <set>

#include "networks/wsn/outgoing.h"

namespace rubicon::networks::wsn {

/// Asks motes whether they are there, a few at a time, so that a restart with many of them keeps the radio free.
class MoteProbes {
 public:
  static constexpr std::size_t kAtATime = 4;
  using DoneCall = std::function<void(Delivered)>;

  MoteProbes(std::uint16_t island, MoteRequests& requests) : island_(island), requests_(requests) {}

  /// A mote that waits or is being asked is not asked twice: then `done` is not called, and the result is false.
  bool ask(std::uint16_t mote, DoneCall done);
  std::uint64_t asked() const { return asked_; }
  std::size_t waiting() const { return waiting_.size(); }

 private:
  void next();

  std::uint16_t island_;
  MoteRequests& requests_;
  std::deque<std::pair<std::uint16_t, DoneCall>> waiting_;
  std::set<std::uint16_t> known_;  ///< waiting or being asked
  std::size_t under_way_ = 0;
  std::uint64_t asked_ = 0;
};

}  // namespace rubicon::networks::wsn
