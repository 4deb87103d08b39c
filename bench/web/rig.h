#pragma once

#include <optional>
#include <string>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "web/measurements.h"
#include "web/roles.h"

namespace rubicon::bench::web {

/// A private network with an island, or with mosquitto's WebSocket listener and a publisher. Says in `out` why there is
/// none.
class Rig {
 public:
  Rig(Json& out, const std::string& what);

  explicit operator bool() const { return network_.entered(); }
  RoleProcess island(const Plan& plan) const { return {"island", plan.devices}; }
  /// mosquitto, at kBrokerPort for programs and kSocketPort for browsers; nullopt where it is not installed.
  std::optional<support::MosquittoOptions> broker() const;

  static constexpr int kBrokerPort = 1883, kSocketPort = 9001;

 private:
  support::PrivateNetwork network_;
};

/// Waits until a broker accepts connections; throws if it does not.
void await_broker(const support::Mosquitto& broker);

}  // namespace rubicon::bench::web
