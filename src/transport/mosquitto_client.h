#pragma once

#include <mosquitto.h>

#include <chrono>
#include <memory>

#include "transport/mqtt_exchange.h"

namespace rubicon::transport {

/// Connects to a broker and serves the exchange until the connection fails, which it reports, or the exchange is
/// dismissed. Blocks: for the thread of a line.
void run_mosquitto(const MqttOptions& options, MqttExchange& exchange);

/// The broker's answer, without the client id: `properties` of a CONNACK of version 5, else nullptr.
MqttConnack read_connack(const mosquitto_property* properties, bool version_5, Duration our_keep_alive);

/// The most publications of QoS 1 without an answer that the broker takes (Receive Maximum; MQTT 5, section 3.2.2.3.3).
std::size_t read_receive_maximum(const mosquitto_property* properties);

struct FreeProperties {
  void operator()(mosquitto_property* properties) const { ::mosquitto_property_free_all(&properties); }
};
using Properties = std::unique_ptr<mosquitto_property, FreeProperties>;

/// Of a CONNECT of version 5.
Properties connect_properties(const MqttOptions& options);
/// Of a PUBLISH of version 5; nullptr = none.
Properties publish_properties(const MqttPublication& publication);
/// Of a received one; nullptr = none.
std::unique_ptr<MqttAbout> read_about(const mosquitto_property* properties);

/// The library closes its socket right after the DISCONNECT. If bytes of the broker were not read by then, the system
/// resets the connection, and the broker never sees the DISCONNECT. With a second descriptor the connection stays until
/// the broker closes it.
class KeptSocket {
 public:
  /// Of the library's socket.
  explicit KeptSocket(int socket);
  ~KeptSocket();
  KeptSocket(const KeptSocket&) = delete;
  KeptSocket& operator=(const KeptSocket&) = delete;

  /// Ends our direction, and reads until the broker ends the other.
  void await_end(std::chrono::steady_clock::time_point latest) const;

 private:
  int descriptor_;
};

/// mosquitto leaves Nagle's algorithm on: it holds a small message back until the one before is acknowledged, and the
/// system delays that by 40 ms on a connection that also sends.
void acknowledge_now(int socket);

/// The other side ended the connection, and nothing waits to be read.
bool is_ended(int socket);

}  // namespace rubicon::transport
