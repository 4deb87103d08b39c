#pragma once

#include <string>
#include <vector>

#include "bridges/mqtt/entities.h"

namespace rubicon::bridges::mqtt {

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
  void complete(const About& about, Entity& entity) const;
  nlohmann::ordered_json device_json(const DeviceEntry& device) const;
  bool takes(const PointEntry& point) const;

  const Options& options_;
  House& house_;
  std::string home_;
};

}  // namespace rubicon::bridges::mqtt
