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
#include "transport/mqtt.h"

namespace rubicon::transport {

struct MemorySession;

/// An MQTT broker in memory, in the time of its MemoryNet, which must outlive it. Its clients are lines of
/// MemoryTransports::open_mqtt, which may outlive it. What a client subscribes to by several filters it gets once.
class MqttBroker {
 public:
  /// What a client published, or its will.
  struct Publication {
    std::string client, topic, payload;
    bool retain = false;
    std::uint8_t qos = 0;
    bool will = false;
    SteadyTime at{};
  };

  /// Runs at once. `at`: the numeric address of its host and a free port (asserted).
  MqttBroker(MemoryNet& net, Endpoint at);
  ~MqttBroker();
  MqttBroker(const MqttBroker&) = delete;
  MqttBroker& operator=(const MqttBroker&) = delete;

  Duration latency = std::chrono::microseconds(100);  ///< of each packet, one way
  bool answers = true;                                ///< if false, it accepts connections and sends nothing
  bool speaks_5 = true;                               ///< if false, it refuses version 5
  std::size_t largest_packet = 268'435'460;           ///< in bytes; it closes the connection after a longer one
  std::map<std::string, std::string> users{};         ///< with their passwords; empty = it accepts all users
  std::set<std::string> refused_filters{};            ///< subscriptions to exactly these are refused
  std::set<std::string> ignored_topics{};             ///< filters: what clients publish there is dropped (access list)
  std::set<std::string> refused_topics{};  ///< as ignored_topics; a client of version 5 is told (reason 0x87, QoS 1)
  bool acknowledges = true;                ///< publications of QoS 1
  bool keeps_published = true;             ///< if false, published() stays empty
  bool repeats = false;                    ///< each message of QoS 1 arrives twice
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
  /// While stalled, nothing passes in either direction. A line is lost after its keep-alive time.
  void stall(bool stalled);

  /// As a client that is not here; not part of published().
  void publish(std::string_view topic, std::string_view payload, bool retain = false, std::uint8_t qos = 0);

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
  void watch(const SessionPtr& session);
  void connect(const SessionPtr& session);
  void reach(const SessionPtr& session);
  std::optional<int> refusal(const MqttOptions& options) const;
  void accept(const SessionPtr& session);
  void take_in(const SessionPtr& session);
  void subscribe(const SessionPtr& session, const std::string& filter, std::uint8_t qos);
  void take(const SessionPtr& from, const MqttPublication& publication, bool will);
  void acknowledge(const SessionPtr& session, const MqttPublication& publication, bool refused);
  void spread(const MqttPublication& publication);
  void deliver(const SessionPtr& to, const MqttPublication& message, bool retained);
  void leave(const SessionPtr& session);
  void forget(const SessionPtr& session);
  void drop(const SessionPtr& session, const Error& why, bool with_will);
  void break_all(bool with_wills);

  MemoryNet& net_;
  Endpoint at_;
  std::vector<SessionPtr> sessions_;  ///< also those that wait for an answer
  Retained retained_;
  std::vector<Publication> published_;
  std::map<std::uint64_t, Timer> flights_;
  std::uint64_t last_flight_ = 0;
  SteadyTime last_arrival_{};
  std::deque<std::function<void()>> held_;  ///< what arrived while stalled
  bool stalled_ = false;
};

}  // namespace rubicon::transport
