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

/// What the broker publishes for us if the connection is lost (MQTT 5, section 3.1.2.5). With an empty payload and
/// `retain` it removes the retained message of the topic, and the subscribers get the empty message.
struct MqttWill {
  std::string topic, payload;
  bool retain = true;
  std::uint8_t qos = 1;  ///< 0 or 1
};

struct MqttOptions {
  std::string host;
  std::uint16_t port = 1883;
  std::string client_id;  ///< at most 23 of `[0-9A-Za-z]`, which each broker must accept; empty = made by the line
  std::string user, password;
  std::optional<MqttTls> tls{};
  MqttVersion version = MqttVersion::kAny;
  std::optional<MqttWill> will{};
  /// Of the CONNECT (MQTT 5, section 3.1.2.10), in whole seconds; 5 s to 65535 s, or what the broker wants instead
  /// (MqttConnack). The line pings when it sent nothing, or heard nothing, for this long; a broker that does not answer
  /// within the same time again is lost: after one to two of these times. A broker publishes the will of a line that it
  /// does not hear for one and a half of them; mosquitto 2.0 looks each 5 s, so up to 5 s later.
  Duration keep_alive = std::chrono::seconds(15);
  Duration connect_time = std::chrono::seconds(10);  ///< without CONNACK after this time the line has failed
  /// Longest packet that is accepted, in bytes. A longer one is dropped and counted; a broker of version 5 does not
  /// send it.
  std::size_t largest_packet = std::size_t{16} * 1024 * 1024;
};

/// What the broker said when it accepted the connection (CONNACK; MQTT 5, section 3.2.2.3). One of version 3.1.1 says
/// nothing more: all but `version` are then as below, or our own.
struct MqttConnack {
  MqttVersion version = MqttVersion::k5;  ///< that is spoken: k5 or k311
  std::size_t largest_packet = 0;         ///< that it takes, in bytes; 0 = not known. It may have a limit all the same.
  bool retains = true;                    ///< if false, it keeps no retained messages: those are sent on as all others
  Duration keep_alive{};                  ///< in force: the broker's if it has one (Server Keep Alive), else ours
  std::string_view client_id{};  ///< the client id of MqttOptions, or the one that the line made; valid during the call
};

/// A received message; valid during the call.
struct MqttMessage {
  std::string_view topic;
  std::string_view payload;
  bool retained = false;  ///< a stored copy, sent because of a new subscription
  /// The rest is of version 5 (MQTT 5, section 3.3.2.3): what remains of its Message Expiry Interval, zero = without
  /// end; where an answer is wanted, and what belongs into it; the user property `sender`.
  Duration expiry{};
  std::string_view response_topic{}, correlation{}, sender{};
};

/// Reason codes of a PUBACK that a caller may want to tell apart (MQTT 5, section 3.4.2.1); others come as their
/// number. Reasons of 0x80 and above mean that the broker did not take the message.
enum class MqttReason : std::uint8_t {
  kSuccess = 0x00,
  kNoSubscribers = 0x10,  ///< taken, but no client subscribes to the topic
  kUnspecified = 0x80,    ///< also: the library did not take it
  kNotAuthorised = 0x87,
  kQuotaExceeded = 0x97,
  kTooLarge = 0x95,  ///< mosquitto's `message_size_limit`, which its CONNACK does not tell
};

/// What became of a publication of QoS 1; valid during the call.
struct MqttOutcome {
  std::string_view topic;
  std::uint64_t number = 0;                  ///< MqttPublication::number
  MqttReason reason = MqttReason::kSuccess;  ///< always success if a broker of version 3.1.1 took it
};

/// Called from the loop, never inside a call to the line. Each may destroy the line.
struct MqttCallbacks {
  /// The broker accepted the connection. Called once.
  std::function<void(const MqttConnack& connack)> connected;
  std::function<void(const MqttMessage& message)> received;
  /// A packet beyond MqttOptions::largest_packet was dropped; with its length in bytes. Only in version 3.1.1: a broker
  /// of version 5 does not send it and reports nothing.
  std::function<void(std::string_view topic, std::size_t bytes)> too_long;
  /// The broker granted a subscription (its SUBACK). For each call of subscribe() either this or `refused` is called,
  /// in the order of these calls, unless the connection fails before. Neither a right to the messages (mosquitto's
  /// `acl_file` grants all and then stays silent), nor the end of the retained ones, which follow.
  std::function<void(std::string_view filter)> subscribed;
  /// The broker refused a subscription (an access list), or does not take a packet with this filter.
  std::function<void(std::string_view filter, Error why)> refused;
  /// The broker took a publication of QoS 1 (its PUBACK). This does not mean that anybody gets it: a broker drops it
  /// silently for a subscriber whose queue is full, and one of version 3.1.1 says so of what it drops for all. For each
  /// publication either this or `not_taken` is called, in the order of publications (MQTT 5, section 4.6), unless the
  /// connection fails before, or a later one took its place (MqttQueue::kLatest).
  std::function<void(const MqttOutcome& outcome)> taken;
  /// The broker, or the library, did not take a publication of QoS 1: a reason code of 0x80 or above in its PUBACK.
  /// Brokers of version 3.1.1 have no such answer. kRefused: an access list forbids to publish there; kOutOfRange: it
  /// is too large.
  std::function<void(const MqttOutcome& outcome, Error why)> not_taken;
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
  /// How long the broker keeps it, for new subscribers if it is retained, and at QoS 1 for those that do not read
  /// (Message Expiry Interval; MQTT 5, section 3.3.2.3.3). The time begins when the message arrives there; rounded up
  /// to seconds, at most 136 years; zero = without end. A broker of version 3.1.1 does not learn it. It does not bound
  /// the age of a message at its delivery: mosquitto delivers messages that wait at QoS 0 even after this time.
  Duration expiry{};
  std::uint64_t number = 0;  ///< the caller's; comes back in MqttOutcome
  /// Where an answer is wanted, and what belongs into it (MQTT 5, sections 3.3.2.3.5 and 3.3.2.3.6); of an answer only
  /// the latter. A broker of version 3.1.1 does not learn them.
  std::string response_topic{}, correlation{};
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
/// broker takes it within a second. Messages leave at the end of the turn of the loop that published them, or when much
/// waits; small ones are not held back (TCP_NODELAY).
///
/// Received messages come in the order in which the broker sends them. A loop that takes them more slowly than they
/// come makes the line stop reading at kMaxUndelivered; from then on the broker must wait, and it drops what is beyond
/// its own limits: mosquitto the newest, silently, at QoS 1 too, and at QoS 0 also its answers to subscriptions and
/// publications. A broker that owes such an answer, or one to a ping, for two keep-alive times is lost. So is one whose
/// messages wait that long because the loop stands still.
class MqttLine {
 public:
  /// Bounds of what waits for a busy line: publications, and their bytes.
  static constexpr std::size_t kMaxQueued = 10'000, kMaxQueuedBytes = std::size_t{8} * 1024 * 1024;
  /// Of filters that wait to be asked for, or for their answer, in bytes.
  static constexpr std::size_t kMaxAskedBytes = std::size_t{4} * 1024 * 1024;
  /// Bytes of events on their way to the loop, beyond which the line stops reading. Up to 256 KiB, or one message, more
  /// may come.
  static constexpr std::size_t kMaxUndelivered = std::size_t{4} * 1024 * 1024;

  virtual ~MqttLine() = default;
  /// Asks for the messages of a filter, with this QoS at most; once more for its retained messages. May be called
  /// before `connected`. kInvalid for a wrong filter, kBusy beyond kMaxAskedBytes.
  virtual Result<void> subscribe(std::string_view filter, std::uint8_t qos = 0) = 0;
  virtual Result<void> unsubscribe(std::string_view filter) = 0;
  /// Sends the message, or queues it. kUnreachable if not connected, kBusy beyond the bounds of the queue, kInvalid for
  /// a wrong topic, kOutOfRange if the packet exceeds the broker's Maximum Packet Size (version 5).
  virtual Result<void> publish(MqttPublication publication) = 0;
  virtual MqttCounters counters() const = 0;
};

/// 1 to 65535 bytes of UTF-8 without control characters (U+0000..001F, U+007F..009F) and noncharacters (U+FDD0..FDEF,
/// U+xxFFFE, U+xxFFFF): what each client and broker accepts (MQTT 5, section 1.5.4).
bool is_mqtt_text(std::string_view text);
/// A topic of a message (MQTT 5, section 4.7): such a text without wildcards. At most 200 levels: mosquitto
/// closes the connection of a client that subscribes or publishes to more.
bool is_mqtt_topic(std::string_view topic);
/// What a subscription may ask for: as above, with `+` for one level and `#` for the rest as its last level.
bool is_mqtt_filter(std::string_view filter);
/// Wildcards at the beginning do not match topics that begin with `$`.
bool mqtt_matches(std::string_view filter, std::string_view topic);

/// The broker in texts of errors: `MQTT broker.lan:1883`.
std::string mqtt_name(const MqttOptions& options);

/// kInvalid with the reason, for what no broker can accept.
Result<void> check_options(const MqttOptions& options);
Result<void> check_filter(std::string_view filter, std::uint8_t qos, const std::string& line);
/// Also kOutOfRange beyond the broker's longest packet, in bytes.
Result<void> check_publication(const MqttPublication& publication, std::size_t largest, const std::string& line);

/// Length in bytes of a PUBLISH packet with this topic and payload (MQTT 5, section 3.3), within a few bytes.
std::size_t packet_size(std::string_view topic, std::string_view payload);

/// What a reason code of CONNACK or DISCONNECT means to the user of a line (MQTT 5, section 2.4).
Error mqtt_error(int reason, const std::string& line);
/// What a reason code of PUBACK (0x80 or above) means for a publication to this topic (MQTT 5, section 3.4.2.1).
Error publication_error(int reason, const std::string& line, std::string_view topic);
/// The reason of version 5 for a return code of a CONNACK of 3.1.1 (section 3.2.2.3 there).
int reason_of_return_code(int code);

}  // namespace rubicon::transport
