#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash_index.h"
#include "base/scheduler.h"
#include "transport/mqtt.h"

namespace rubicon::transport {

/// Publications that wait for a busy line, within the bounds of MqttLine. A message of kind kLatest replaces the
/// waiting message of its topic and takes its position; all others keep their order.
class MqttOutQueue {
 public:
  /// kBusy beyond the bounds.
  Result<void> push(MqttPublication publication, const std::string& line);
  /// The oldest; nullopt if none waits.
  std::optional<MqttPublication> pop();
  /// The oldest that may leave together: of QoS 0, then up to so many of QoS 1; about MqttBatch::kEnough bytes.
  void take(std::size_t most_of_qos_1, std::vector<MqttPublication>& taken);
  bool empty() const { return waiting_.empty(); }
  std::size_t size() const { return waiting_.size(); }
  std::size_t bytes() const { return bytes_; }

 private:
  static constexpr std::uint32_t kNumbers = 0x7fff'ffff;

  MqttPublication& at(std::uint32_t number) { return waiting_[(number - first_) & kNumbers]; }
  /// Of the state of this topic that waits, by the hash of the topic; HashIndex::kNone: there is none.
  std::uint32_t find(std::uint32_t hash, std::string_view topic);

  std::deque<MqttPublication> waiting_;
  base::HashIndex latest_;   ///< numbers of states that wait, by topic
  std::uint32_t first_ = 0;  ///< number of waiting_.front()
  std::size_t bytes_ = 0;
};

class MqttExchange;

/// Where the threads of MQTT lines find the loop, until it ends. Shared, because a thread that waits for a name server
/// may outlive the loop. Bounds the threads: one that waits for a host lives on when its line was destroyed.
class MqttHome {
 public:
  static constexpr std::size_t kMaxThreads = 256;
  /// Of destroyed lines to one broker, as long as they wait for its host: a host that is not found takes no threads
  /// from other brokers.
  static constexpr std::size_t kMaxStuck = 16;

  explicit MqttHome(Scheduler& scheduler) : scheduler_(&scheduler) {}

  /// From any thread; dropped once closed.
  void post(std::function<void()> call);
  /// A thread begins to serve the exchange. kBusy beyond the bounds.
  Result<void> enter(const MqttExchange& exchange);
  void leave(const MqttExchange& exchange);
  /// A thread begins or ends to have a connection that must be closed in order.
  void connected(bool now);
  /// Waits until no thread has a connection, at most for this time. Then nothing is posted any longer.
  void close(Duration patience);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  Scheduler* scheduler_;
  std::vector<const MqttExchange*> served_;  ///< one for each thread
  int connections_ = 0;
};

/// What version 5 says of a message beside its text.
struct MqttAbout {
  Duration expiry{};
  std::string response_topic{}, correlation{}, sender{};
};

/// What the thread of an MQTT line reports to the loop.
struct MqttEvent {
  enum class Kind : std::uint8_t { kConnected, kReceived, kTooLong, kSubscribed, kRefused, kTaken, kNotTaken, kFailed };

  Kind kind = Kind::kReceived;
  std::string topic,
      payload{};  ///< of a message; kTooLong has no payload; kSubscribed, kRefused: the filter is the topic
  bool retained = false;
  MqttReason reason = MqttReason::kSuccess;  ///< kTaken, kNotTaken
  std::uint64_t number = 0;                  ///< kTaken, kNotTaken: of the publication; kTooLong: bytes of the packet
  Error why{};                               ///< kRefused, kNotTaken, kFailed
  std::unique_ptr<MqttConnack> connack{};    ///< kConnected
  std::unique_ptr<MqttAbout> about{};        ///< kReceived; null = nothing
};

/// A filter to subscribe to, or to unsubscribe from.
struct MqttAsk {
  std::string filter;
  std::uint8_t qos = 0;
  bool wanted = true;
};

/// What a thread sends next.
struct MqttWork {
  std::vector<MqttAsk> asks;
  std::vector<MqttPublication> publications;

  bool empty() const { return asks.empty() && publications.empty(); }
};

/// What the loop and the thread of an MQTT line hand to each other. Both directions are bounded: publications by
/// MqttOutQueue, events by may_read().
class MqttExchange {
 public:
  /// `line` names it in errors: mqtt_name(). `on_events` is called on the loop when there is something to take().
  /// nullptr if the system has no descriptors.
  static std::shared_ptr<MqttExchange> make(std::shared_ptr<MqttHome> home, std::string line,
                                            std::function<void()> on_events);
  MqttExchange(std::shared_ptr<MqttHome> home, std::string line) : home_(std::move(home)), line_(std::move(line)) {}
  ~MqttExchange();
  MqttExchange(const MqttExchange&) = delete;
  MqttExchange& operator=(const MqttExchange&) = delete;

  // The loop.
  /// The thread hears of it when much waits, or at flush().
  Result<void> publish(MqttPublication publication);
  void flush() const { wake(); }
  /// kBusy beyond MqttLine::kMaxAskedBytes.
  Result<void> ask(MqttAsk ask);
  /// Makes the thread close its connection and end.
  void dismiss();
  std::vector<MqttEvent> take();
  /// The loop is done with that many bytes of events.
  void delivered(std::size_t bytes);

  // The thread.
  /// Readable when the thread has something to do.
  int wake_descriptor() const { return wake_; }
  void clear_wake() const;
  bool dismissed() const { return dismissed_; }
  bool may_read() const { return in_flight_ < MqttLine::kMaxUndelivered; }
  /// Puts into `work` all that is asked for. If there is nothing, what MqttOutQueue::take() has; nothing for nullopt.
  void take_work(std::optional<std::size_t> most_of_qos_1, MqttWork& work);
  /// The broker answered it, or will not.
  void answered_ask(const MqttAsk& ask) { asked_bytes_ -= cost(ask); }
  void tell(std::vector<MqttEvent> events);
  MqttHome& home() { return *home_; }
  const std::string& line() const { return line_; }

  static std::size_t cost(const MqttEvent& event);
  static std::size_t cost(const MqttAsk& ask) { return sizeof ask + ask.filter.size(); }

  std::atomic<std::uint64_t> sent{0}, too_long{0}, not_taken{0};
  std::atomic<bool> answered{false};  ///< the host accepted a connection

 private:
  void wake() const;

  std::shared_ptr<MqttHome> home_;
  std::string line_;
  std::function<void()> on_events_;
  int wake_ = -1;
  std::atomic<bool> dismissed_{false};
  std::atomic<std::size_t> in_flight_{0}, asked_bytes_{0};
  std::mutex mutex_;
  MqttOutQueue out_;
  std::vector<MqttAsk> asks_;
  std::vector<MqttEvent> events_;
};

}  // namespace rubicon::transport
