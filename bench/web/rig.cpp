#include "web/rig.h"

#include <fmt/format.h>
#include <unistd.h>

#include <stdexcept>

namespace rubicon::bench::web {

Rig::Rig(Json& out, const std::string& what) {
  if (!network_.entered()) out[what + "_skipped"] = network_.reason();
}

std::optional<support::MosquittoOptions> Rig::broker() const {
  if (!support::Mosquitto::missing().empty()) return std::nullopt;
  support::MosquittoOptions options;
  options.port = kBrokerPort;
  options.more = fmt::format("listener {} 127.0.0.1\nprotocol websockets\n", kSocketPort);
  return options;
}

void await_broker(const support::Mosquitto& broker) {
  for (int i = 0; i < 2000 && !broker.ready(); ++i) ::usleep(5'000);
  if (!broker.ready()) throw std::runtime_error("mosquitto does not come up");
}

}  // namespace rubicon::bench::web
