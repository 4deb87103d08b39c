#include "apps/rubicon/broker_look.h"

#include <fmt/format.h>

#include <random>

#include "client/ecology_options.h"
#include "transport/poll_loop.h"
#include "transport/poll_sockets.h"
#include "tuples/mqtt/messages.h"

namespace rubicon::cli {

namespace {

namespace mqtt = tuples::mqtt;

/// In whose name nobody may write.
constexpr const char* kProbe = "-probe-";
constexpr const char* kLastMessage = "fence";
/// Of users and components that are kept of one broker.
constexpr std::size_t kMaxSeen = 100'000;

class BrokerLook {
 public:
  BrokerLook(transport::PollLoop& loop, tuples::mqtt::SpaceOptions options)
      : loop_(loop), options_(std::move(options)), topics_(options_.space) {
    seen_.place = fmt::format("{}:{}", broker().host, broker().port);
    seen_.space = options_.space;
    seen_.user = options_.brokers.front().user;
    seen_.tls = broker().tls.has_value();
    own_.user = seen_.user;
    std::random_device source;
    own_.token = fmt::format("{:04x}{:08x}", source() & 0xffffU, source());
  }

  BrokerSeen look(Duration patience) {
    broker().connect_time = patience;
    auto opened = sockets_.open_mqtt(broker(), calls());
    if (!opened) {
      seen_.failure = opened.error();
      return std::move(seen_);
    }
    line_ = std::move(*opened);
    wait([this] { return connected_; }, 2 * patience);  // of both versions of MQTT
    if (connected_) wait([this] { return seen_.hands_on; }, patience);
    for (const auto& [at, id] : components_) {
      if (!lines_.contains(at)) seen_.ghosts.emplace_back(at.user, id);
    }
    return std::move(seen_);
  }

 private:
  transport::MqttOptions& broker() { return options_.brokers.front().line; }
  template <class Done>
  void wait(Done done, Duration most) {
    const auto ends = loop_.now() + most;
    for (auto now = loop_.now(); !done() && !seen_.failure && now < ends; now = loop_.now()) {
      loop_.wait(ends - now);
      loop_.poll();
    }
  }

  transport::MqttCalls calls() {
    transport::MqttCalls calls;
    calls.connected = [this](const transport::MqttConnack& connack) { on_connected(connack); };
    calls.received = [this](const transport::MqttMessage& message) { on_message(message); };
    calls.failed = [this](const Error& why) { seen_.failure = why; };
    return calls;
  }

  /// The inbox first: a forged message to it would arrive before the last one. The other forged one stands where only
  /// this program reads.
  void on_connected(const transport::MqttConnack& connack) {
    connected_ = true;
    seen_.version = connack.version;
    seen_.retains = connack.retains;
    const mqtt::Line other{kProbe, own_.token};
    forged_ = {topics_.inbox(own_, other),
               fmt::format("rubicon-space/1/{}/p/probe/{}/{}", options_.space, kProbe, own_.token)};
    for (const auto& filter : {topics_.inbox_filter(own_), fmt::format("rubicon-space/1/{}/p/#", options_.space)})
      std::ignore = line_->subscribe(filter, 0);
    for (const auto& topic : forged_) std::ignore = line_->publish({topic, "probe", false, 0, {}, {}, 0});
    std::ignore = line_->publish({topics_.inbox(own_, own_), kLastMessage, false, 0, {}, {}, 0});
  }

  void on_message(const transport::MqttMessage& message) {
    if (message.topic == topics_.inbox(own_, own_)) seen_.hands_on = true;
    seen_.forges |= forged_.contains(std::string(message.topic));
    if (message.payload.empty()) return;
    if (const auto user = topics_.user_of_document(message.topic)) {
      seen_.documents[*user] = message.payload;
      return;
    }
    const auto at = topics_.parse(message.topic);
    const auto* presence = std::get_if<mqtt::Topics::Presence>(&at);
    if (presence == nullptr || components_.size() + lines_.size() >= kMaxSeen) return;
    auto& ids = seen_.users[presence->line.user];
    if (!presence->component) return void(lines_.insert(presence->line));
    ids.insert(*presence->component);
    components_.emplace(presence->line, *presence->component);
  }

  transport::PollLoop& loop_;
  transport::PollSockets sockets_{loop_};
  tuples::mqtt::SpaceOptions options_;
  mqtt::Topics topics_;
  mqtt::Line own_;
  std::set<std::string> forged_;
  std::set<mqtt::Line> lines_;
  std::set<std::pair<mqtt::Line, OwnerId>> components_;
  bool connected_ = false;
  BrokerSeen seen_;
  std::unique_ptr<transport::MqttLine> line_;
};

}  // namespace

BrokerSeen look_at_broker(const client::Options& options, Duration patience) {
  BrokerSeen none;
  none.place = options.broker.host;
  auto engines = client::engine_options(options);
  auto loop = transport::PollLoop::make();
  if (!engines) none.failure = engines.error();
  if (!loop) none.failure = loop.error();
  if (none.failure) return none;
  return BrokerLook(**loop, std::move(*engines->mqtt)).look(patience);
}

}  // namespace rubicon::cli
