#pragma once

#include <optional>

#include "tuples/peis/tuple_wire.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

template <class Body>
Result<Bytes> written(const Result<Body>& body) {
  if (!body) return fail(body.error());
  return write(*body);
}

/// The body of a port, read and written again; nullopt for ports without a reader here.
inline std::optional<Result<Bytes>> rewritten(Port port, ByteView body) {
  switch (port) {
    case Port::kRouting: return written(read_routing_page(body));
    case Port::kTrace:
    case Port::kTraceReply: return written(read_trace(body));
    case Port::kSubscribe: return written(read_subscribe(body));
    case Port::kUnsubscribe: return written(read_unsubscribe(body));
    case Port::kPush: return read_push(body).map(write_push);
    case Port::kDeadHost: return written(read_dead_host(body));
    case Port::kSetRemote: return read_set_remote(body).map(write_set_remote);
    case Port::kTimeSync: return written(read_time_sync(body));
    case Port::kQueryHost: return written(read_query_host(body));
    case Port::kHostInfo: return written(read_host_info(body));
    case Port::kAcks: return written(read_acks(body));
    case Port::kSetAppend: return written(read_set_append(body));
    case Port::kPushAppended: return written(read_push_appended(body));
    default: return std::nullopt;
  }
}

}  // namespace rubicon::tuples::peis
