#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::transport {

/// Which version of MQTT to speak: 5 first and then 3.1.1, or only one of them.
enum class MqttVersion : std::uint8_t { kAny, k311, k5 };

/// How the broker is authenticated, and optionally we by it. Empty files: the CA certificates of the system, no client
/// certificate.
struct MqttTls {
  std::string ca_file;
  std::string certificate_file, key_file;  ///< both or none
  std::string server_name;                 ///< expected in the broker's certificate; empty = the host
};

/// What the broker publishes for us if the connection is lost (MQTT 5, section 3.1.2.5).
struct MqttWill {
  std::string topic, payload;
  bool retain = true;
};

struct MqttOptions {
  std::string host;
  std::uint16_t port = 1883;
  std::string client_id;  ///< at most 23 of `[0-9A-Za-z]`, which each broker must accept; empty = made by the line
  std::string user, password;
  std::optional<MqttTls> tls{};
  MqttVersion version = MqttVersion::kAny;
  std::optional<MqttWill> will{};
  Duration keep_alive = std::chrono::seconds(30);  ///< a broker that says nothing for this long is lost; at least 10 s
  Duration connect_time = std::chrono::seconds(10);  ///< without CONNACK after this time the line has failed
  /// Longest packet that is accepted, in bytes. A longer one is dropped and counted; a broker of version 5 does not
  /// send it.
  std::size_t largest_packet = std::size_t{16} * 1024 * 1024;
};

/// A received message; valid during the call.
struct MqttMessage {
  std::string_view topic;
  std::string_view payload;
  bool retained = false;  ///< a stored copy, sent because of a new subscription
};

/// Called from the loop, never inside a call to the line. Each may destroy the line.
struct MqttCalls {
  /// The broker accepted the connection.
  std::function<void()> connected;
  std::function<void(const MqttMessage& message)> received;
  /// A packet beyond MqttOptions::largest_packet was dropped; with its length in bytes. Only in version 3.1.1: a broker
  /// of version 5 does not send it and reports nothing.
  std::function<void(std::string_view topic, std::size_t bytes)> too_long;
  /// The broker refused a subscription (an access list), or does not take a packet with this filter.
  std::function<void(std::string_view filter, Error why)> refused;
  /// The broker took a publication of QoS 1 (its PUBACK). One of version 3.1.1 says so of what it drops too. For each
  /// publication either this or `not_taken` is called, in the order of publications (MQTT 5, section 4.6), unless the
  /// connection fails before.
  std::function<void(std::string_view topic)> taken;
  /// The broker, or the library, did not take a publication of QoS 1: a reason code of 0x80 or above in its PUBACK
  /// (MQTT 5, section 3.4.2.1). Brokers of version 3.1.1 have no such answer. kRefused: an access list forbids to
  /// publish there.
  std::function<void(std::string_view topic, Error why)> not_taken;
  /// The connection failed or was lost; the line should be destroyed. kRefused: the broker is there and does not accept
  /// us (user, password, version, client id). Called once.
  std::function<void(Error why)> failed;
};

/// What a publication means to the queue of outgoing messages.
enum class MqttQueue : std::uint8_t {
  kInOrder,  ///< each message is sent: commands, requests
  kLatest,   ///< a newer message of the topic replaces one that waits: states
};

struct MqttPublication {
  std::string topic, payload;
  bool retain = false;
  std::uint8_t qos = 0;  ///< 0 or 1
  MqttQueue queue = MqttQueue::kInOrder;
};

struct MqttCounters {
  std::uint64_t received = 0, sent = 0;
  std::uint64_t too_long = 0;  ///< received packets beyond MqttOptions::largest_packet, dropped; 0 in version 5
  /// Publications that the library or the broker did not take; the broker reports only QoS 1 in version 5.
  std::uint64_t not_taken = 0;

  MqttCounters& operator+=(const MqttCounters& other) {
    received += other.received;
    sent += other.sent;
    too_long += other.too_long;
    not_taken += other.not_taken;
    return *this;
  }
};

/// A connection to an MQTT broker (MQTT 3.1.1 or 5, OASIS). Always a clean session. It does not reconnect. Destroying
/// it closes it with a DISCONNECT, so that the broker does not publish the will; what waits is sent before, if the
/// broker takes it within a second.
class MqttLine {
 public:
  /// Bounds of what waits for a busy line.
  static constexpr std::size_t kMaxQueued = 10'000, kMaxQueuedBytes = std::size_t{8} * 1024 * 1024;

  virtual ~MqttLine() = default;
  /// Asks for the messages of a filter, with this QoS at most. May be called before `connected`. kInvalid for a wrong
  /// filter.
  virtual Result<void> subscribe(std::string_view filter, std::uint8_t qos = 0) = 0;
  virtual Result<void> unsubscribe(std::string_view filter) = 0;
  /// Sends the message, or queues it. kUnreachable if not connected, kBusy beyond the bounds of the queue, kInvalid for
  /// a wrong topic, kOutOfRange if the packet exceeds the broker's Maximum Packet Size (version 5).
  virtual Result<void> publish(MqttPublication publication) = 0;
  virtual MqttCounters counters() const = 0;
};

}  // namespace rubicon::transport
