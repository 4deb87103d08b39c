#include "transport/udp.h"

#include <fmt/format.h>

namespace rubicon::transport {

std::string to_string(const Endpoint& endpoint) {
  const bool six = endpoint.address.find(':') != std::string::npos;
  return six ? fmt::format("[{}]:{}", endpoint.address, endpoint.port)
             : fmt::format("{}:{}", endpoint.address.empty() ? "*" : endpoint.address, endpoint.port);
}

}  // namespace rubicon::transport
