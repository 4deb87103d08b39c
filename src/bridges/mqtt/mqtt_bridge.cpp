#include "bridges/mqtt/mqtt_bridge.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <utility>

#include "base/scheduler.h"
#include "base/text.h"
#include "bridges/house.h"
#include "bridges/mqtt/broker_line.h"
#include "bridges/mqtt/commands.h"
#include "bridges/mqtt/discovery.h"
#include "bridges/mqtt/payloads.h"
#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

namespace {

using transport::MqttPublication;
using transport::MqttQueue;

constexpr const char *kOnline = "/online", *kYes = "online", *kNo = "offline";
/// After that announcements in another form are there.
constexpr Duration kMigration = std::chrono::seconds(10);
/// Attributes of a point come at most once in this time.
constexpr Duration kAttributesPause = std::chrono::seconds(1);
constexpr Duration kAnnouncePause = std::chrono::milliseconds(100);
/// After Home Assistant's birth message: all bridges answer it.
constexpr int kBirthFirst = 1000, kBirthLast = 10'000;  // ms
constexpr Duration kSample = std::chrono::seconds(60), kMaxSample = std::chrono::hours(1);

MqttPublication state(std::string topic, std::string payload, std::uint8_t qos = 0) {
  return {std::move(topic), std::move(payload), true, qos, MqttQueue::kLatest};
}

/// Points and devices that wait to be published are marked, once each. So their number is bounded, and the newest value
/// wins. Everything is published in one place, go(), as long as the line takes it.
class MqttBridge final : public Bridge {
 public:
  MqttBridge(Options options, const BridgeHost& host)
      : host_(host),
        options_(std::move(options)),
        home_(fmt::format("{}/{}", options_.base,
                          host.island ? fmt::to_string(number(*host.island)) : "bridge-" + host.name)),
        house_(host_, options_, house_calls()),
        announcer_(options_, house_, home_),
        leftovers_(options_, house_, announcer_),
        commands_(host_, options_, house_,
                  {[this](MqttPublication message) { line_.publish_in_order(std::move(message)); },
                   [this](const std::string& topic) { correct(topic); }}),
        line_(host_, options_.broker, {home_ + kOnline, kNo, true, 1}, line_calls()),
        soon_(host.scheduler, [this] { go(); }) {}
  ~MqttBridge() override { say_goodbye(); }

  void start() override {
    house_.start();
    line_.open();
  }

  BridgeStatus status() const override {
    auto status = line_.status();
    if (status.state == "up" && leftovers_.is_disputed())
      status.reason += std::string(status.reason.empty() ? "" : "; ") +
                       "another program announces devices under our ids: two bridges for one island?";
    if (status.state == "up" && silent_)
      status.reason += std::string(status.reason.empty() ? "" : "; ") +
                       "no value that it publishes comes back: the access list of the broker may hide " + options_.base;
    status.counters["births"] = births_;
    status.counters["devices"] = house_.devices();
    status.counters["points"] = house_.points();
    status.counters["events"] = events_;
    status.counters["commands"] = commands_.taken();
    status.counters["commands-refused"] = commands_.refused();
    return status;
  }

 private:
  House::Callbacks house_calls() {
    return {.point = [this](PointEntry& point) { mark(point); },
            .status = [this](PointEntry& point) { mark_status(point); },
            .device = [this](DeviceEntry& device) { mark(device); },
            .network = [this](NetworkEntry& network) { mark_small(network); },
            .island = [this](IslandEntry& island) { mark_small(island); },
            .point_gone = [this](PointEntry& point) { forget(point); },
            .device_gone = [this](DeviceEntry& device) { forget(device); },
            .renamed = [this](DeviceEntry& device) { forget_topics(device); },
            .network_gone =
                [this](OwnerId island, const std::string& id) {
                  forget_small(fmt::format("rubicon_{}_{}", number(island), id),
                               fmt::format("{}/{}", house_.island_topic(island), id));
                },
            .island_gone = [this](IslandEntry& island) { forget(island); },
            .is_ours = [this](std::string_view origin) { return is_broker(options_, origin); }};
  }
  BrokerLine::Callbacks line_calls() {
    return {.connected = [this](const transport::MqttConnack&) { connected(); },
            .received = [this](const transport::MqttMessage& message) { received(message); },
            .roomy = [this] { go(); },
            .lost = [] {}};
  }

  void connected();
  void received(const transport::MqttMessage& message);
  void migrate(const std::string& topic);
  void sample(std::string_view topic, std::string_view payload);
  void mark(PointEntry& point);
  void mark_status(PointEntry& point);
  void mark(DeviceEntry& device);
  void mark_again(DeviceEntry& device);
  template <class Entry>
  void mark_small(Entry& entry) {
    entry.dirty = true;
    small_dirty_ = true;
    soon_.request();
  }
  void mark_all();
  void forget(const IslandEntry& gone);
  void go();
  bool publish_small();
  template <class Entry>
  bool publish_small(Entry& entry, bool online);
  bool publish(DeviceEntry& device);
  bool publish(PointEntry& point);
  bool publish_state(PointEntry& point);
  void publish_event(PointEntry& point);
  void publish_attributes();
  bool announce(DeviceEntry& device);
  void want(PointEntry& point);
  void correct(const std::string& topic);
  void forget(PointEntry& point);
  void forget(DeviceEntry& device);
  void forget_topics(DeviceEntry& device);
  void forget_small(const std::string& object, const std::string& topic);
  void remove(const std::string& topic);
  void sweep();
  void say_goodbye();

  BridgeHost host_;
  Options options_;
  std::string home_;
  House house_;
  Announcer announcer_;
  Leftovers leftovers_;
  Commands commands_;
  BrokerLine line_;
  std::vector<PointEntry*> points_;    ///< that are dirty
  std::vector<DeviceEntry*> devices_;  ///< that are dirty
  std::set<PointEntry*> statuses_;     ///< that changed
  bool small_dirty_ = false;           ///< an island or a network is
  std::set<std::string> announced_;    ///< of islands and networks
  std::set<std::string> removed_;      ///< topics to empty
  std::set<std::string> migrated_;     ///< of another form of discovery
  std::uint64_t events_ = 0, births_ = 0;
  bool heard_own_ = false;  ///< a value that it published came back
  bool silent_ = false;     ///< none did, long enough
  Timer birth_, settled_, later_, migration_, attributes_;
  base::OncePerTurn soon_;
};

void MqttBridge::connected() {
  std::vector<std::string> filters = leftovers_.filters();
  leftovers_.begin();
  heard_own_ = silent_ = false;
  for (const auto& filter : filters) line_.subscribe(filter, 0);
  if (!options_.commands.empty()) line_.subscribe(options_.base + "/+/+/+/+/+/set", 1);
  if (options_.on_request) line_.subscribe(options_.base + "/+/+/+/+/+/sample", 0);
  if (options_.discovery != Discovery::kNone) line_.subscribe(options_.discovery_base + "/status", 0);
  settled_ = host_.scheduler.after(Leftovers::kSettled, [this] { sweep(); });
  mark_all();
}

/// Everything is published again, in the order of go().
void MqttBridge::mark_all() {
  line_.publish_in_order({home_ + kOnline, kYes, true, 1});
  house_.each_island([this](IslandEntry& island) { mark_small(island); });
  house_.each_network([this](NetworkEntry& network) { mark_small(network); });
  house_.each_device([this](DeviceEntry& device) {
    device.online.reset();
    mark_again(device);
    for (auto* point : device.points) {
      point->online.reset();
      mark(*point);
      mark_status(*point);
    }
  });
}

void MqttBridge::received(const transport::MqttMessage& message) {
  if (message.topic.ends_with("/set")) return commands_.take(message);
  if (message.topic.ends_with("/sample") && options_.on_request) return sample(message.topic, message.payload);
  if (message.topic == options_.discovery_base + "/status") {
    if (message.payload != kYes || message.retained) return;
    ++births_;
    static std::minstd_rand random{std::random_device{}()};
    const std::chrono::milliseconds pause(kBirthFirst + static_cast<int>(random() % (kBirthLast - kBirthFirst)));
    birth_ = host_.scheduler.after(pause, [this] { mark_all(); });
    return;
  }
  if (leftovers_.is_other_form(message)) return migrate(std::string(message.topic));
  leftovers_.take(message);
  auto* point = house_.find_by_topic(message.topic);
  heard_own_ |= point != nullptr;
  if (point && message.retained) mark(*point);
}

/// The receiver keeps what people set for these entities. So the bridge announces that they move, then the new place,
/// and then removes the old announcement.
void MqttBridge::migrate(const std::string& topic) {
  line_.publish_in_order({topic, R"({"migrate_discovery": true})", true, 1});
  migrated_.insert(topic);
  house_.each_device([this](DeviceEntry& device) { mark_again(device); });
  house_.each_network([this](NetworkEntry& network) { mark_small(network); });
  house_.each_island([this](IslandEntry& island) { mark_small(island); });
  migration_ = host_.scheduler.after(kMigration, [this] {
    for (const auto& old : std::exchange(migrated_, {})) remove(old);
  });
}

void MqttBridge::sample(std::string_view topic, std::string_view payload) {
  auto* point = house_.find_by_topic(topic.substr(0, topic.rfind('/')));
  if (point == nullptr || point->kind == model::Kind::kActuator) return;
  if (host_.judge && !host_.judge->access({"bridge:" + host_.name}, point->key + ".value").demand) return;
  const auto lasts = std::min(base::parse_duration(payload).value_or(kSample), kMaxSample);
  if (!point->demand)
    point->demand = host_.space.subscribe({point->device->island, point->key + ".value"}, {}, [](const Event&) {});
  point->demand_ends = host_.scheduler.after(lasts, [point] { point->demand.reset(); });
}

/// `demand: {active: ...}`.
void MqttBridge::want(PointEntry& point) {
  if (point.demand || !any_key_matches(options_.active, point.key + ".value")) return;
  if (host_.judge && !host_.judge->access({"bridge:" + host_.name}, point.key + ".value").demand) return;
  point.demand = host_.space.subscribe({point.device->island, point.key + ".value"}, {}, [](const Event&) {});
}

void MqttBridge::mark(PointEntry& point) {
  if (!point.demand && !options_.active.empty()) want(point);
  if (std::exchange(point.dirty, true)) return;
  points_.push_back(&point);
  soon_.request();
}

void MqttBridge::mark_status(PointEntry& point) {
  if (!options_.attributes) return;
  statuses_.insert(&point);
  if (!attributes_.pending()) attributes_ = host_.scheduler.after(kAttributesPause, [this] { publish_attributes(); });
}

/// Its announcement is published also if it is the same.
void MqttBridge::mark_again(DeviceEntry& device) {
  for (auto& [topic, hash] : device.announced) hash = 0;
  mark(device);
}

void MqttBridge::mark(DeviceEntry& device) {
  if (std::exchange(device.dirty, true)) return;
  devices_.push_back(&device);
  if (!later_.pending()) later_ = host_.scheduler.after(kAnnouncePause, [this] { go(); });
}

/// As far as the line takes it: discovery, then availability, then states.
void MqttBridge::go() {
  if (!line_.connected()) return;
  while (!removed_.empty()) {
    if (!line_.publish(state(*removed_.begin(), {}, 1))) return;
    removed_.erase(removed_.begin());
  }
  if (small_dirty_ && !publish_small()) return;
  if (!later_.pending()) {
    std::vector<DeviceEntry*> wait;
    while (!devices_.empty()) {
      auto* device = devices_.back();
      devices_.pop_back();  // publish() may add others
      if (!house_.is_complete(*device)) {
        wait.push_back(device);
      } else if (!publish(*device)) {
        devices_.push_back(device);
        break;
      }
    }
    devices_.insert(devices_.end(), wait.begin(), wait.end());
    if (!wait.empty()) later_ = host_.scheduler.after(kAnnouncePause, [this] { go(); });
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (publish(*points_[i])) continue;
    points_.erase(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(i));
    return;
  }
  points_.clear();
}

template <class Entry>
bool MqttBridge::publish_small(Entry& entry, bool online) {
  if (!entry.dirty) return true;
  for (const auto& message :
       options_.discovery == Discovery::kNone ? std::vector<Announcement>() : announcer_.of(entry)) {
    if (!line_.publish(state(message.topic, message.payload, 1))) return false;
    announced_.insert(message.topic);
  }
  const bool is_home = entry.topic == home_;  // the will tells about it
  if (!is_home && !line_.publish(state(entry.topic + kOnline, online ? kYes : kNo, 1))) return false;
  entry.dirty = false;
  return true;
}

bool MqttBridge::publish_small() {
  bool all = true;
  house_.each_island([&](IslandEntry& island) { all = all && publish_small(island, island.present); });
  house_.each_network([&](NetworkEntry& network) { all = all && publish_small(network, network.works); });
  small_dirty_ = !all;
  return all;
}

/// Publishes what is new in it, and removes what is not announced any longer.
bool MqttBridge::announce(DeviceEntry& device) {
  const auto messages = announcer_.of(device);
  std::map<std::string, std::size_t> now;
  bool changed = false;
  for (const auto& message : messages) {
    const auto hash = std::hash<std::string>()(message.payload) | 1U;
    auto& known = device.announced[message.topic];
    if (known != hash && !line_.publish(state(message.topic, message.payload, 1))) return false;
    changed |= std::exchange(known, hash) != hash;
    now[message.topic] = hash;
  }
  for (const auto& [topic, hash] : std::exchange(device.announced, now)) {
    if (!now.contains(topic)) remove(topic);
  }
  for (auto* group : changed ? house_.groups_of(device) : std::vector<DeviceEntry*>()) mark(*group);
  return true;
}

bool MqttBridge::publish(DeviceEntry& device) {
  if (options_.discovery != Discovery::kNone && !announce(device)) return false;
  const bool online = !device.is_away();
  if (device.online != online && !line_.publish(state(device.topic + kOnline, online ? kYes : kNo, 1))) return false;
  device.online = online;
  device.dirty = false;
  return true;
}

bool MqttBridge::publish(PointEntry& point) {
  if (point.about && point.is_event() && point.fresh) publish_event(point);
  if (point.about && !point.is_event() && !publish_state(point)) return false;
  point.dirty = false;
  return true;
}

void MqttBridge::publish_event(PointEntry& point) {
  point.fresh = false;
  ++events_;
  line_.publish_in_order({point.topic(), payload_of(point, options_), false, 0});
}

/// A value that is not good any longer is taken away: who connects later must not take it for one of now.
bool MqttBridge::publish_state(PointEntry& point) {
  const bool online = is_online(point);
  const bool has = point.good() || options_.json;
  if (point.kind != model::Kind::kActuator && point.online != online) {
    if (!line_.publish(state(point.topic(kOnline), online ? kYes : kNo))) return false;
    point.online = online;
  }
  auto topic = point.topic();
  point.shown = point.shown || leftovers_.has(topic);
  if (has) {
    if (point.value.empty() && !options_.json) return true;
    if (!line_.publish(state(std::move(topic), payload_of(point, options_)))) return false;
    point.shown = true;
  } else if (point.shown && !options_.keep) {
    if (!line_.publish(state(std::move(topic), {}))) return false;
    point.shown = false;
  }
  return true;
}

void MqttBridge::publish_attributes() {
  while (!statuses_.empty()) {
    auto& point = **statuses_.begin();
    const auto status = host_.space.get(point.device->island, point.key + ".status");
    const auto topic = point.topic("/attributes");
    if (status && !line_.publish({topic, attributes_of(point, status->value), false, 0, MqttQueue::kLatest})) {
      attributes_ = host_.scheduler.after(kAttributesPause, [this] { publish_attributes(); });
      return;
    }
    statuses_.erase(statuses_.begin());
  }
}

/// Receivers that show the commanded value get the present one.
void MqttBridge::correct(const std::string& topic) {
  if (auto* point = house_.find_by_topic(topic)) mark(*point);
}

void MqttBridge::remove(const std::string& topic) {
  removed_.insert(topic);
  soon_.request();
}

void MqttBridge::forget(PointEntry& point) {
  statuses_.erase(&point);
  if (point.dirty) std::erase(points_, &point);
  point.dirty = false;
  if (point.shown) remove(point.topic());
  if (point.online) remove(point.topic(kOnline));
  point.shown = false;
  point.online.reset();
}

void MqttBridge::forget_topics(DeviceEntry& device) {
  for (auto* point : device.points) forget(*point);
  if (device.online) remove(device.topic + kOnline);
  device.online.reset();
}

void MqttBridge::forget(DeviceEntry& device) {
  forget_topics(device);
  if (device.dirty) std::erase(devices_, &device);
  device.dirty = false;
  for (const auto& [topic, hash] : std::exchange(device.announced, {})) remove(topic);
}

/// An island or a network: its announcements, in which it is the device `object`, and whether it is there.
void MqttBridge::forget_small(const std::string& object, const std::string& topic) {
  std::erase_if(announced_, [&](const std::string& announcement) {
    const bool gone = announcement.find("/" + object + "/") != announcement.npos;
    if (gone) remove(announcement);
    return gone;
  });
  if (topic != home_) remove(topic + kOnline);  // that of the bridge itself stays
}

/// An island that has its name now stands at its topics, which were emptied: all of it is said again.
void MqttBridge::forget(const IslandEntry& gone) {
  forget_small(fmt::format("rubicon_{}", number(gone.id)), gone.topic);
  bool is_shared = false;
  house_.each_island([&](const IslandEntry& one) { is_shared |= one.id != gone.id && one.topic == gone.topic; });
  if (is_shared) mark_all();
}

/// Removes what an earlier run left, and ends its subscriptions, which would bring our own messages from now on.
void MqttBridge::sweep() {
  auto kept = announced_;
  house_.each_device([&](DeviceEntry& device) {
    for (const auto& [topic, hash] : device.announced) kept.insert(topic);
  });
  for (const auto& topic : leftovers_.gone(kept)) remove(topic);
  for (const auto& filter : leftovers_.filters()) line_.unsubscribe(filter);
  bool shown = false;
  house_.each_device([&](DeviceEntry& device) {
    for (const auto* point : device.points) shown |= point->shown;
  });
  silent_ = shown && !heard_own_;  // a broker does not tell what its access list drops
}

/// In order, so that the broker does not publish the will.
void MqttBridge::say_goodbye() {
  if (!line_.connected()) return;
  line_.publish_last({home_ + kOnline, kNo, true, 1});
  house_.each_island([this](IslandEntry& island) {
    if (island.topic != home_) line_.publish_last(state(island.topic + kOnline, kNo, 1));
  });
}

}  // namespace

std::unique_ptr<Bridge> make(ConfigReader& options, const std::string& directory, const BridgeHost* host) {
  const auto before = options.errors().lines().size();
  options.node("type");
  auto read = read_options(options, directory);
  options.finish();
  if (host == nullptr || options.errors().lines().size() != before) return nullptr;
  return std::make_unique<MqttBridge>(std::move(read), *host);
}

}  // namespace rubicon::bridges::mqtt
