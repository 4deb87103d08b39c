#include "web/rig.h"

#include <fmt/format.h>
#include <unistd.h>

#include <stdexcept>

namespace rubicon::bench::web {

namespace {

std::unique_ptr<support::Mosquitto> start_broker() {
  support::MosquittoOptions options;
  options.port = Peer::kBrokerPort;
  options.more = fmt::format("listener {} 127.0.0.1\nprotocol websockets\n", Peer::kSocketPort);
  auto broker = std::make_unique<support::Mosquitto>(options);
  for (int i = 0; i < 2000 && !broker->ready(); ++i) ::usleep(5'000);
  if (!broker->ready()) throw std::runtime_error("mosquitto does not come up");
  return broker;
}

}  // namespace

Rig::Rig(Json& out, const std::string& what) {
  if (!network_.entered()) out[what + "_skipped"] = network_.reason();
}

std::unique_ptr<Peer> Rig::peer(const Plan& plan) const {
  return support::Mosquitto::missing().empty() ? std::make_unique<Peer>(plan) : nullptr;
}

Peer::Peer(const Plan& plan) : broker(start_broker()), publisher("publisher", plan.devices, kBrokerPort) {}

}  // namespace rubicon::bench::web
