#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "support/memory/memory_udp.h"
#include "support/memory/mqtt_rights.h"
#include "transport/mqtt.h"

namespace rubicon::transport {

struct MemoryPacket;
struct MemorySession;

/// An MQTT broker in memory, in the time of its MemoryNet, which must outlive it. Its clients are lines of
/// MemoryTransports::open_mqtt, which may outlive it. It does what mosquitto 2.0.11 was seen to do
/// (tests/transport/mqtt_both_test.cpp); what a client subscribes to by several filters it gets once for each.
class MqttBroker {
 public:
  static constexpr std::size_t kMaxPacketSize = 268'435'460;

  /// What a client published, or its will.
  struct Publication {
    std::string client, topic, payload;
    bool retain = false;
    std::uint8_t qos = 0;
    bool will = false;
    SteadyTime at{};
    std::string correlation{};
    Duration expiry{};
  };

  /// Runs at once. `at`: the numeric address of its host and a free port (asserted).
  MqttBroker(MemoryNet& net, Endpoint at);
  ~MqttBroker();
  MqttBroker(const MqttBroker&) = delete;
  MqttBroker& operator=(const MqttBroker&) = delete;

  Duration latency = std::chrono::microseconds(100);  ///< of each packet, one way
  bool answers = true;                                ///< if false, it accepts connections and sends nothing
  bool speaks_5 = true;                               ///< if false, it refuses version 5
  /// In bytes; told in version 5 if it is not this. It closes the connection after a longer one.
  std::size_t largest_packet = kMaxPacketSize;
  /// Of a payload in bytes (`message_size_limit`): not told; a longer one is dropped, with reason 0x95 in version 5.
  std::size_t largest_payload = kMaxPacketSize;
  bool retains = true;  ///< if false (`retain_available`), as told in version 5, it refuses what is to be retained
  Duration longest_keep_alive = std::chrono::seconds(65535);  ///< (`max_keepalive`), told in version 5
  std::map<std::string, std::string> users{};                 ///< with their passwords; empty = it accepts all users
  /// By user. Forbidden subscriptions are granted and silent; forbidden publications are dropped, with reason 0x87 in
  /// version 5 and QoS 1; a forbidden will is accepted and never published.
  std::optional<MqttRights> rights{};
  /// What waits for one client that does not read: messages of QoS 0 up to `max_queued`, of QoS 1 up to both
  /// (`max_queued_messages`, `max_inflight_messages`), also in one burst. The newest beyond that are dropped, and
  /// nobody is told. Retained messages of a new subscription at QoS 0 are not bounded. QoS 0 overtakes what waits of
  /// QoS 1. A real broker has the buffers of a socket on top, and may drop its answers too.
  std::size_t max_queued = 1000, max_in_flight = 20;
  Duration looks_each = std::chrono::seconds(5);  ///< at most so late it sees that a client is silent for too long
  bool tells_take_over = false;                   ///< reason 0x8e in version 5; mosquitto just closes
  /// Whether this message to this client is lost on the way, silently; for tests that lose one of their choice.
  std::function<bool(const std::string& client, const MqttPublication& message)> loses{};
  std::set<std::string> refused_filters{};  ///< subscriptions to exactly these are refused
  std::set<std::string> ignored_topics{};   ///< filters: what clients publish there is dropped (access list)
  std::set<std::string> refused_topics{};   ///< as ignored_topics; a client of version 5 is told (reason 0x87, QoS 1)
  bool acknowledges = true;                 ///< publications of QoS 1
  bool keeps_published = true;              ///< if false, published() stays empty
  bool repeats = false;                     ///< each message of QoS 1 arrives twice
  std::function<void(const Publication&)> heard{};  ///< of each publication, as it arrives

  void start();
  /// Breaks all connections, without wills; new ones are refused.
  void stop(bool keep_retained);
  using Retained = std::map<std::string, std::string, std::less<>>;
  /// Stops and starts, as a broker that was killed and saves its retained messages only now and then: it has those of
  /// an earlier time (retained()) again.
  void restart(Retained saved);
  bool runs() const;
  /// Breaks all connections, or that of one client, and publishes the wills.
  void cut();
  void cut(std::string_view client);
  /// While stalled, nothing passes in either direction. A line is lost after two keep-alive times.
  void stall(bool stalled);
  /// The same for the connections that this client has now: half-open ones, if it is not undone. The line is lost after
  /// two keep-alive times, and the broker ends the connection, with its will, after one and a half and `looks_each`,
  /// also if the line was destroyed meanwhile.
  void stall(std::string_view client, bool stalled);
  /// The connection of this client takes one message each so long; zero = at once.
  void slow(std::string_view client, Duration each);

  /// As a client that is not here; not part of published().
  void publish(std::string_view topic, std::string_view payload, bool retain = false, std::uint8_t qos = 0,
               Duration expiry = {});
  /// The same with all that version 5 has.
  void publish(const MqttPublication& publication) { spread(publication); }

  const std::vector<Publication>& published() const { return published_; }
  /// The payloads that clients published to this topic.
  std::vector<std::string> published(std::string_view topic) const;
  void forget_published() { published_.clear(); }
  /// By topic.
  const Retained& retained() const { return retained_; }
  std::optional<std::string> retained(std::string_view topic) const;
  /// Client ids of those that are connected, sorted.
  std::vector<std::string> clients() const;
  /// The filters of all clients.
  std::set<std::string> subscriptions() const;

 private:
  friend class MemoryMqttLine;
  using SessionPtr = std::shared_ptr<MemorySession>;

  void transit(std::function<void()> call);
  void send(const SessionPtr& to, MemoryPacket packet);
  bool has_room(const MemorySession& to, std::uint8_t qos) const;
  void drain(const SessionPtr& to);
  void go(const SessionPtr& to, const MemoryPacket& packet);
  void begin_stall(const SessionPtr& session);
  void end_stall(const SessionPtr& session);
  void end_half_open(const SessionPtr& session);
  void watch(const SessionPtr& session);
  void connect(const SessionPtr& session);
  void reach(const SessionPtr& session);
  std::optional<int> refusal(const MqttOptions& options) const;
  void accept(const SessionPtr& session);
  void take_in(const SessionPtr& session);
  void subscribe(const SessionPtr& session, const std::string& filter, std::uint8_t qos);
  void take(const SessionPtr& from, const MqttPublication& publication);
  void take_will(const MemorySession& from);
  std::optional<Error> end_of(const MemorySession& from, const MqttPublication& publication) const;
  int fault_of(const MemorySession& from, const MqttPublication& publication) const;
  void acknowledge(const SessionPtr& session, const MqttPublication& publication, int reason);
  void retain(const MqttPublication& publication);
  bool spread(const MqttPublication& publication);
  void deliver(const SessionPtr& to, const MqttPublication& message, bool retained);
  void leave(const SessionPtr& session);
  void forget(const SessionPtr& session);
  void drop(const SessionPtr& session, const Error& why, bool with_will);
  void break_all(bool with_wills);

  MemoryNet& net_;
  Endpoint at_;
  std::vector<SessionPtr> sessions_;  ///< also those that wait for an answer
  Retained retained_;
  std::map<std::string, Timer, std::less<>> expiries_;  ///< of retained messages
  std::vector<Publication> published_;
  std::map<std::uint64_t, Timer> flights_;
  std::uint64_t last_flight_ = 0;
  SteadyTime last_arrival_{};
  std::deque<std::function<void()>> held_;  ///< what arrived while stalled
  bool stalled_ = false;
};

}  // namespace rubicon::transport
