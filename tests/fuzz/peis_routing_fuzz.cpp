#include <cstdlib>

#include "fuzz_target.h"
#include "tuples/peis/rewritten.h"

namespace rubicon::fuzz::peis_routing_fuzz {

namespace {

using namespace rubicon::tuples::peis;

constexpr Port kPorts[] = {Port::kRouting, Port::kAcks,      Port::kDeadHost, Port::kTimeSync,
                           Port::kTrace,   Port::kQueryHost, Port::kHostInfo, Port::kTraceReply};

}  // namespace

/// Input: which message of the node level, then its body. What was read is written as something that reads the same, in
/// no more bytes.
FUZZ_TARGET(peis_routing) {
  if (size == 0) return 0;
  const auto port = kPorts[data[0] % std::size(kPorts)];
  const auto once = rewritten(port, ByteView(data + 1, size - 1));
  if (!*once) {
    if (once->error().text.empty()) std::abort();
    return 0;
  }
  if ((*once)->size() != size - 1) std::abort();
  const auto twice = rewritten(port, **once);
  if (!*twice || **twice != **once) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::peis_routing_fuzz
