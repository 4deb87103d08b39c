#pragma once

#include <memory>
#include <string>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "web/measurements.h"
#include "web/roles.h"

namespace rubicon::bench::web {

/// mosquitto, at kBrokerPort for programs and kSocketPort for browsers, and who publishes the values to it.
struct Peer {
  static constexpr int kBrokerPort = 1883, kSocketPort = 9001;

  explicit Peer(const Plan& plan);

  std::unique_ptr<support::Mosquitto> broker;
  RoleProcess publisher;
};

/// A private network with an island, or with mosquitto's WebSocket listener and a publisher. Says in `out` why there is
/// none.
class Rig {
 public:
  Rig(Json& out, const std::string& what);

  explicit operator bool() const { return network_.entered(); }
  RoleProcess island(const Plan& plan) const { return {"island", plan.devices}; }
  /// nullptr where mosquitto is not installed.
  std::unique_ptr<Peer> peer(const Plan& plan) const;

 private:
  support::PrivateNetwork network_;
};

}  // namespace rubicon::bench::web
