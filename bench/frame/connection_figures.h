#pragma once

namespace rubicon::bench {

/// Bytes of IP packets, headers and bare acknowledgements included.
struct Passed {
  double received = 0, sent = 0;
};
/// What passed so far on the TCP connections over IPv4 that this process has now, as the kernel counts it.
Passed passed_on_connections();

}  // namespace rubicon::bench
