#include "transport/machine_sockets.h"

#include <fmt/format.h>
#include <mosquitto.h>

#include <deque>
#include <limits>
#include <random>
#include <system_error>
#include <thread>
#include <utility>

#include "base/scheduler.h"
#include "model/findings.h"
#include "transport/mosquitto_client.h"
#include "transport/mqtt.h"
#include "transport/mqtt_exchange.h"

namespace rubicon::transport {

namespace {

/// What is delivered in one turn of the loop; the rest waits for the next.
constexpr std::size_t kEventsPerTurn = 256, kDeliveredPerTurn = std::size_t{1} << 20U;
/// A little longer than a thread takes for what waits.
constexpr auto kClosingPatience = std::chrono::milliseconds(1500);

std::string random_client_id() {
  constexpr std::string_view kDigits = "0123456789abcdefghijklmnopqrstuvwxyz";
  std::random_device source;
  std::string id = "rubicon";
  while (id.size() < 23) id += kDigits[source() % kDigits.size()];
  return id;
}

MqttMessage message_of(const MqttEvent& event) {
  MqttMessage message{event.topic, event.payload, event.retained};
  if (!event.about) return message;
  const auto& about = *event.about;
  message.expiry = about.expiry;
  message.response_topic = about.response_topic;
  message.correlation = about.correlation;
  message.sender = about.sender;
  return message;
}

/// The loop's side of a connection.
class MosquittoLine final : public MqttLine {
 public:
  MosquittoLine(Scheduler& scheduler, MqttOptions options, MqttCallbacks calls)
      : scheduler_(scheduler),
        options_(std::move(options)),
        name_(mqtt_name(options_)),
        callbacks_(std::make_shared<const MqttCallbacks>(std::move(calls))),
        flush_(scheduler, [this] { exchange_->flush(); }),
        patience_(scheduler, [this] { give_up(); }) {}
  ~MosquittoLine() override {
    if (exchange_) exchange_->dismiss();
  }
  MosquittoLine(const MosquittoLine&) = delete;
  MosquittoLine& operator=(const MosquittoLine&) = delete;

  Result<void> begin(const std::shared_ptr<MqttHome>& home) {
    exchange_ = MqttExchange::make(home, name_, lifetime_.guard([this] { deliver(); }));
    if (!exchange_) return fail(ErrorCode::kIo, name_ + ": no descriptors left");
    if (auto entered = home->enter(*exchange_); !entered) return entered;
    try {
      std::thread([home, exchange = exchange_, options = options_] {
        run_mosquitto(options, *exchange);
        home->leave(*exchange);
      }).detach();
    } catch (const std::system_error& refused) {
      home->leave(*exchange_);
      return fail(ErrorCode::kIo, fmt::format("{}: cannot start a thread: {}", name_, refused.what()));
    }
    options_.password.clear();
    patience_.set(options_.connect_time);
    return {};
  }

  Result<void> subscribe(std::string_view filter, std::uint8_t qos) override {
    if (auto right = check_filter(filter, qos, name_); !right) return right;
    return exchange_->ask({std::string(filter), qos, true});
  }
  Result<void> unsubscribe(std::string_view filter) override {
    if (auto right = check_filter(filter, 0, name_); !right) return right;
    return exchange_->ask({std::string(filter), 0, false});
  }
  Result<void> publish(MqttPublication publication) override {
    if (!connected_) return fail(ErrorCode::kUnreachable, name_ + ": cannot publish: not connected");
    if (auto right = check_publication(publication, broker_takes_, name_); !right) return right;
    auto queued = exchange_->publish(std::move(publication));
    if (queued) flush_.request();
    return queued;
  }
  MqttCounters counters() const override {
    return {received_, exchange_->sent, exchange_->too_long, exchange_->not_taken};
  }

 private:
  /// Some events; each of their calls may destroy this.
  void deliver() {
    for (auto& event : exchange_->take()) events_.push_back(std::move(event));
    const auto watch = lifetime_.watch();
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < kEventsPerTurn && bytes < kDeliveredPerTurn && !events_.empty(); ++i) {
      const auto event = std::move(events_.front());
      events_.pop_front();
      bytes += MqttExchange::cost(event);
      if (!failed_) handle(event);
      if (watch.ended()) return;
    }
    exchange_->delivered(bytes);
    if (!events_.empty()) lifetime_.post(scheduler_, [this] { deliver(); });
  }

  void handle(const MqttEvent& event) {
    const auto calls = callbacks_;
    switch (event.kind) {
      case MqttEvent::Kind::kConnected: return become_connected(*event.connack);
      case MqttEvent::Kind::kReceived:
        ++received_;
        if (calls->received) calls->received(message_of(event));
        return;
      case MqttEvent::Kind::kTooLong:
        if (calls->too_long) calls->too_long(event.topic, event.number);
        return;
      case MqttEvent::Kind::kSubscribed:
        if (calls->subscribed) calls->subscribed(event.topic);
        return;
      case MqttEvent::Kind::kRefused:
        if (calls->refused) calls->refused(event.topic, event.why);
        return;
      case MqttEvent::Kind::kTaken:
        if (calls->taken) calls->taken({event.topic, event.number, event.reason});
        return;
      case MqttEvent::Kind::kNotTaken:
        if (calls->not_taken) calls->not_taken({event.topic, event.number, event.reason}, event.why);
        return;
      case MqttEvent::Kind::kFailed: return end(event.why);
    }
  }

  void become_connected(MqttConnack& connack) {
    connected_ = true;
    if (connack.largest_packet > 0) broker_takes_ = connack.largest_packet;
    connack.client_id = options_.client_id;
    patience_.clear();
    const auto calls = callbacks_;
    if (calls->connected) calls->connected(connack);
  }

  void give_up() {
    exchange_->dismiss();
    const auto seconds = std::chrono::duration<double>(options_.connect_time).count();
    const bool answered = exchange_->answered;
    const auto* what = answered ? "the host accepted the connection, the broker does not answer"
                                : "the host cannot be found or does not answer";
    end({ErrorCode::kUnreachable, fmt::format("{}: {} within {} s", name_, what, seconds),
         answered ? model::findings::kBrokerSilent : model::findings::kHostSilent});
  }

  void end(const Error& why) {
    failed_ = true;
    connected_ = false;
    patience_.clear();
    const auto calls = callbacks_;
    if (calls->failed) calls->failed(why);
  }

  Scheduler& scheduler_;
  MqttOptions options_;
  std::string name_;
  std::shared_ptr<const MqttCallbacks> callbacks_;  ///< a call may destroy this
  base::OncePerTurn flush_;                         ///< what is published in one turn leaves together
  base::Deadline patience_;
  std::shared_ptr<MqttExchange> exchange_;
  std::deque<MqttEvent> events_;
  std::size_t broker_takes_ = std::numeric_limits<std::size_t>::max();
  std::uint64_t received_ = 0;
  bool connected_ = false, failed_ = false;
  base::Lifetime lifetime_;
};

}  // namespace

MosquittoLines::MosquittoLines(Scheduler& scheduler)
    : scheduler_(scheduler), home_(std::make_shared<MqttHome>(scheduler)) {}

MosquittoLines::~MosquittoLines() {
  home_->close(kClosingPatience);
}

Result<std::unique_ptr<MqttLine>> MosquittoLines::open(const MqttOptions& options, MqttCallbacks calls) {
  [[maybe_unused]] static const int once = ::mosquitto_lib_init();  // never cleaned up: a thread may outlive main()
  if (auto right = check_options(options); !right) return fail(right.error());
  auto complete = options;
  if (complete.client_id.empty()) complete.client_id = random_client_id();
  auto line = std::make_unique<MosquittoLine>(scheduler_, std::move(complete), std::move(calls));
  if (auto begun = line->begin(home_); !begun) return fail(begun.error());
  return line;
}

}  // namespace rubicon::transport
