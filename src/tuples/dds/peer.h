#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "tuples/dds/channel.h"
#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Another component as this one knows it. A component that starts again has a new incarnation, the later the higher.
struct Peer {
  static constexpr std::size_t kMostStarts = 4;

  /// What one of its starts says of itself, and the participant that says it.
  struct Start {
    Participant participant{};
    std::string host, summary;
    std::uint64_t place = 0;  ///< in the order in which starts came here
  };
  using Starts = std::map<std::uint64_t, Start>;
  /// Those that are there, by incarnation: at most one of a participant, kMostStarts in all. The highest counts; two =
  /// it just started again, or its id is taken twice.
  Starts alive;

  std::uint64_t incarnation = 0;  ///< that the listener was told of; 0 = none
  Participant participant{};      ///< of that incarnation
  std::string summary;            ///< that the listener was told

  std::unique_ptr<Channel> channel;  ///< made when something is to be told
  std::uint64_t last_request = 0;    ///< of its remote sets; what comes again is dropped
  std::uint64_t requests_of = 0;     ///< the incarnation that made them

  bool is_up() const { return incarnation != 0; }
};

}  // namespace rubicon::tuples::dds
