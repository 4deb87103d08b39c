#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "client/message_client.h"
#include "client/peer_discovery.h"
#include "web/access/access.h"
#include "web/api/event_types.h"

namespace rubicon::web::api {

/// What all requests and conversations share; outlives them.
struct Context {
  Context(Scheduler& a_scheduler, TupleSpace& a_space, base::LogSink& log, access::Access& its_access)
      : scheduler(a_scheduler),
        space(a_space),
        access(its_access),
        messages(a_scheduler, a_space, log),
        peers(a_scheduler, a_space),
        event_types(a_space) {}

  /// Counters for `/metrics`.
  struct Counters {
    std::uint64_t requests = 0, frames_in = 0, frames_out = 0, bytes_out = 0, commands = 0, lost_events = 0, busy = 0;
    std::size_t conversations = 0, subscriptions = 0, streams = 0;  ///< at present
  };

  Scheduler& scheduler;
  TupleSpace& space;
  access::Access& access;
  client::MessageClient messages;
  client::PeerDiscovery peers;
  EventTypes event_types;
  Counters counters;
};

}  // namespace rubicon::web::api
