#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>

#include "tuples/dds/channel.h"

namespace rubicon::tuples::dds {

/// Another component as this one knows it. A component that starts again has a new incarnation, the later the higher.
struct Peer {
  /// Incarnations that are there, with what they say of themselves. The highest counts; two = it just started again, or
  /// its id is taken twice.
  std::map<std::uint64_t, std::string> alive;
  std::uint64_t incarnation = 0;  ///< that the listener was told of; 0 = none
  std::string summary;            ///< that it was told

  struct Interest {
    std::uint64_t incarnation = 0;
    SubscriptionSpec spec;
  };
  std::map<std::uint32_t, Interest> interests;  ///< by slot, also those of incarnations not seen yet

  struct Held {
    std::uint64_t incarnation = 0;
    Bytes content;
  };
  std::deque<Held> held;  ///< frames that came before the news that it is there
  std::size_t held_bytes = 0;

  std::unique_ptr<Channel> channel;  ///< made when something is to be told
  std::uint64_t last_request = 0;    ///< of its remote sets; what comes again is dropped
  std::uint64_t requests_of = 0;     ///< the incarnation that made them

  std::string host;          ///< as it says: host_id() of where it runs
  bool was_refused = false;  ///< a set, because it runs on another host

  bool is_up() const { return incarnation != 0; }
};

}  // namespace rubicon::tuples::dds
