#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "base/time.h"
#include "model/message.h"

namespace rubicon::gateway {

/// Requests of other islands on their way to own networks. Request numbers are unique per asker only, so that each gets
/// a number of ours on the way down, and its own back with the answer. Bounded: the oldest are forgotten.
class ForeignRequests {
 public:
  static constexpr std::size_t kLimit = 10000;
  static constexpr Duration kLongestWait = std::chrono::minutes(1);

  /// Gives the message's request a number of ours, if it has one.
  void lend(Message& message, SteadyTime now);
  /// Undoes lend() on an answer: its own request number, and the asker as destination. False if the request is none of
  /// ours, true and an answer left as it is if it is forgotten.
  bool give_back(Message& answer);

 private:
  struct Asker {
    Address address;
    std::uint64_t request = 0;
    SteadyTime since{};
  };
  std::map<std::uint64_t, Asker> askers_;  ///< by our number, oldest first
  std::uint64_t last_ = std::uint64_t{1} << 63;
};

/// The request number of an Actuate, Sample or SetProperty; nullptr for all others.
std::uint64_t* request_of(Message& message);
/// What an answer to this message names: its request number, or the message's own where it has none.
std::uint64_t answerable_number(const Message& message);

}  // namespace rubicon::gateway
