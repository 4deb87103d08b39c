#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <unordered_map>

#include "model/message.h"

namespace rubicon::gateway {

/// Requests of other islands to our networks get numbers of ours on the way down, so that two islands' requests never
/// meet in one network, and their own back on the acknowledgement. Bounded: the oldest 10,000 unanswered are kept.
class ForeignRequests {
 public:
  /// Replaces the request's number, if the message carries one.
  void translate(Message& message);

  struct Asker {
    Address address;
    std::uint64_t request = 0;
  };
  /// Who asked, when this acknowledgement answers a translated request; forgets it.
  std::optional<Asker> asker(std::uint64_t request);

 private:
  std::unordered_map<std::uint64_t, Asker> open_;
  std::deque<std::uint64_t> order_;
  std::uint64_t last_ = std::uint64_t{1} << 63;  ///< the upper half belongs to translated requests
};

/// The number an answer to this message carries: the request's, else the message's own.
std::uint64_t request_of(const Message& message);

}  // namespace rubicon::gateway
