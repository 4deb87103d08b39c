#pragma once

#include "transport/mqtt_exchange.h"

namespace rubicon::transport {

/// Connects to a broker and serves the exchange until the connection fails, which it tells, or the exchange is
/// dismissed. Blocks: for the thread of a line.
void run_mosquitto(const MqttOptions& options, MqttExchange& exchange);

}  // namespace rubicon::transport
