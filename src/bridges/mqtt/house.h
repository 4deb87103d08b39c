#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "bridges/mqtt/options.h"
#include "model/point_tuples.h"
#include "model/type_catalogue.h"

namespace rubicon::bridges::mqtt {

struct DeviceEntry;

/// A sensor, actuator or property that is mirrored.
struct PointEntry {
  DeviceEntry* device = nullptr;
  model::Kind kind{};
  std::string id, key, topic;  ///< `light-1`, `proxy.wsn-1.7.sensor.light-1`, `rubicon/6541/wsn-1/7/sensor/light-1`
  std::optional<model::PointDescription> about{};
  std::string value{};
  WallTime time{};  ///< when the device measured it, else when its owner wrote it
  model::Quality quality = model::Quality::kUnknown;
  bool fresh = false;            ///< an event that is not published yet
  bool dirty = false;            ///< waits to be published
  bool shown = false;            ///< its value stands at the broker
  std::optional<bool> online{};  ///< as published
  Handle demand{};               ///< it is sampled for us
  Timer demand_ends{};

  bool is_event() const { return about && about->report == "event"; }
  bool can_write() const { return about && about->access != "read"; }
  /// Whether its value is a value of now.
  bool good() const { return quality == model::Quality::kGood || quality == model::Quality::kAssumed; }
  std::string_view type() const { return about ? std::string_view(about->type) : std::string_view(); }
  /// `fridge` of `switch-fridge`.
  std::string_view instance() const { return std::string_view(id).substr(std::min(id.find('-') + 1, id.size())); }
};

struct DeviceEntry {
  OwnerId island{};
  std::string prefix, network, id, key, topic;
  std::optional<model::DeviceDescription> about{};
  std::string status{};                       ///< unknown, reachable or unreachable
  std::map<std::string, PointEntry*> points;  ///< by key: sensors behind actuators and properties
  std::set<std::string> announced{};          ///< topics of discovery that stand at the broker
  SteadyTime since{};
  bool dirty = false;
  std::optional<bool> online{};
};

struct NetworkEntry {
  OwnerId island{};
  std::string id, topic;
  bool works = false, dirty = false;
};

struct IslandEntry {
  OwnerId id{};
  std::string name, prefix, version, topic;
  bool present = false, dirty = false;
};

/// What is mirrored: follows the tuples of the islands that the patterns select, without demand.
class House {
 public:
  struct Calls {
    std::function<void(PointEntry&)> point;    ///< value or quality
    std::function<void(DeviceEntry&)> device;  ///< description, status, points
    std::function<void(NetworkEntry&)> network;
    std::function<void(IslandEntry&)> island;
    std::function<void(PointEntry&)> point_gone;    ///< before it is destroyed
    std::function<void(DeviceEntry&)> device_gone;  ///< with its points
    std::function<void(DeviceEntry&)> renamed;      ///< before its topics change
    std::function<void(OwnerId island, const std::string& network)> network_gone;
  };
  House(const BridgeHost& host, const Options& options, Calls calls);

  void start();
  PointEntry* find_by_topic(std::string_view topic);
  DeviceEntry* find_device(std::string_view topic);
  IslandEntry* find_island(OwnerId id);
  void each_device(const std::function<void(DeviceEntry&)>& visit);
  void each_network(const std::function<void(NetworkEntry&)>& visit);
  void each_island(const std::function<void(IslandEntry&)>& visit);
  bool selects_island(OwnerId id) const;
  std::size_t devices() const { return devices_.size(); }
  std::size_t points() const { return points_.size(); }
  /// Where an island stands among the topics.
  std::string island_topic(OwnerId id) const;

 private:
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>()(text); }
  };
  template <class Entry>
  using ByText = std::unordered_map<std::string, Entry, TextHash, std::equal_to<>>;

  void follow(std::optional<OwnerId> owner);
  void watch(std::optional<OwnerId> owner, const std::string& key, void (House::*take)(const Event&));
  void valued(const Event& event);
  void stated(const Event& event);
  void described(const Event& event);
  void device_stated(const Event& event);
  void device_described(const Event& event);
  void line_stated(const Event& event);
  void broker_named(const Event& event);
  void island_changed(OwnerId id);
  PointEntry* point_at(const TupleView& tuple, bool make);
  DeviceEntry* device_at(OwnerId island, std::string_view key, bool make);
  bool selected(OwnerId owner, std::string_view point_key) const;
  std::string topic_of(const DeviceEntry& device) const;
  void name_again(DeviceEntry& device);
  void forget_point(const std::string& name);
  void forget_device(const std::string& name);
  void forget_network(const std::string& name);

  const BridgeHost& host_;
  const Options& options_;
  Calls calls_;
  WallTime started_{};
  std::map<OwnerId, IslandEntry> islands_;
  std::map<std::string, NetworkEntry> networks_;                 ///< by owner and key
  std::map<std::string, std::unique_ptr<DeviceEntry>> devices_;  ///< by owner and key
  ByText<std::unique_ptr<PointEntry>> points_;                   ///< by owner and key
  ByText<PointEntry*> by_topic_;
  std::set<std::string> foreign_;  ///< owner and key of networks that come from our broker
  std::string name_;               ///< of a look-up, to keep its memory
  std::vector<Handle> handles_;
};

}  // namespace rubicon::bridges::mqtt
