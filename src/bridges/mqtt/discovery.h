#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "bridges/house.h"
#include "bridges/mqtt/mqtt_bridge.h"
#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

/// One entity of Home Assistant: `sensor`, `light`, ...
struct Entity {
  std::string platform;
  std::string id;  ///< among those of the device; never changes: `actuator-lamp-1`
  nlohmann::ordered_json body;
};

/// The entities of a device. One entity may be made of several points (a lamp with its dimmer). Points that `takes`
/// refuses are only shown. Sources: documentation and code of Home Assistant's MQTT integration, 2026.1.
std::vector<Entity> entities_of(const DeviceEntry& device, const std::function<bool(const PointEntry&)>& takes);

/// `Colour temperature 1`.
std::string words_of_id(std::string_view id);

using Points = std::vector<const PointEntry*>;

/// Lights, covers, thermostats, locks, valves, fans and sirens, each made of one or several of the points that can be
/// commanded; they take what they use out of `written`, and of `left` what a thermostat shows.
std::vector<Entity> composites_of(Points& written, Points& left);

/// Those of the device, as many as are announced.
std::vector<std::string> words_of(const PointEntry& point);
/// The second word of a boolean: `on`, `open`, `locked`.
std::string on_word(const PointEntry& point);
/// The topics of what can be commanded and shows its state. Never optimistic: only what is reported is shown.
nlohmann::ordered_json commanded(const PointEntry& point);
std::string entity_id(const PointEntry& point);

/// A retained message of discovery.
struct Announcement {
  std::string topic, payload;
};

/// Makes what Home Assistant needs to know (docs/mqtt.md, "What is announced"): `<base>/device/<id>/config` a device,
/// or `<base>/<platform>/<id>/<entity>/config` an entity.
class Announcer {
 public:
  /// Of one message; larger devices are split into several, which show as one.
  static constexpr std::size_t kMaxEntities = 256, kMaxBytes = std::size_t{256} << 10U;

  /// `home`: the topic that is online while the bridge is.
  Announcer(const Options& options, House& house, std::string home)
      : options_(options), house_(house), home_(std::move(home)) {}

  std::vector<Announcement> of(const DeviceEntry& device) const;
  /// A device that shows whether the network, or the island, is there.
  std::vector<Announcement> of(const NetworkEntry& network) const;
  std::vector<Announcement> of(const IslandEntry& island) const;

  /// `rubicon_6541_wsn-1_7`
  static std::string object_id(const DeviceEntry& device);
  /// Whether a message of discovery is of a bridge like this one: with this `home`.
  bool is_ours(std::string_view payload) const;
  bool is_of_rubicon(std::string_view topic) const;

 private:
  struct About;
  std::vector<Announcement> write(const About& about, std::vector<Entity> entities) const;
  Announcement whole(const About& about, const nlohmann::ordered_json& components, std::size_t part) const;
  void add_members(const DeviceEntry& group, Entity& entity) const;
  void complete(const About& about, Entity& entity) const;
  nlohmann::ordered_json device_json(const DeviceEntry& device) const;
  bool takes(const PointEntry& point) const;

  const Options& options_;
  House& house_;
  std::string home_;
};

/// What an earlier run left at the broker: retained messages of devices that are gone, and announcements of another
/// form. Filled by the retained messages of filters() after each connection.
class Leftovers {
 public:
  /// Until then the devices of an island have come, also those that are heard late.
  static constexpr Duration kSettled = std::chrono::seconds(60);
  static constexpr std::size_t kMaxTopics = 200'000;

  Leftovers(const Options& options, House& house, const Announcer& announcer)
      : options_(options), house_(house), announcer_(announcer) {}

  std::vector<std::string> filters() const;
  void take(const transport::MqttMessage& message);
  /// Whether a value of a run before stands there.
  bool has(std::string_view topic) const { return topics_.contains(topic); }
  /// Whether it is our announcement of a run before, in the form that is not in force: its entities have the same ids.
  bool is_other_form(const transport::MqttMessage& message) const;
  /// A message on a topic of discovery that is ours and says something else: two bridges announce one device.
  bool is_disputed() const { return disputed_; }
  void begin() {
    topics_.clear();
    disputed_ = false;
  }
  /// The topics to empty: what `kept` (announcements) and the house do not have, of islands that are there.
  std::set<std::string> gone(const std::set<std::string>& kept);

 private:
  bool is_gone(const std::string& topic) const;

  const Options& options_;
  House& house_;
  const Announcer& announcer_;
  std::map<std::string, bool, std::less<>> topics_;  ///< whether it is an announcement
  bool disputed_ = false;
};

}  // namespace rubicon::bridges::mqtt
