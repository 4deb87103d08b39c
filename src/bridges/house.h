#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/compare_text.h"
#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "bridges/scope.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "model/type_catalogue.h"

namespace rubicon::bridges {

struct DeviceEntry;

/// A sensor, actuator or property that is mirrored. There are many: what can be told from something else is not kept.
struct PointEntry {
  DeviceEntry* device = nullptr;
  model::Kind kind{};
  std::string key;                                         ///< `proxy.wsn-1.7.sensor.light-1`
  std::shared_ptr<const model::PointDescription> about{};  ///< shared by points that are described alike
  std::string value{};
  WallTime time{};  ///< when the device measured it, else when its owner wrote it
  model::Quality quality = model::Quality::kUnknown;
  bool fresh = false;            ///< an event that is not published yet
  bool dirty = false;            ///< waits to be published
  bool shown = false;            ///< its value stands at the broker
  bool lost = false;             ///< its island is
  std::optional<bool> online{};  ///< as published
  Handle demand{};               ///< it is sampled for us
  Timer demand_ends{};

  bool is_event() const { return about && about->report == "event"; }
  bool can_write() const { return about && about->access != "read"; }
  /// Whether its value is a value of now.
  bool good() const { return quality == model::Quality::kGood || quality == model::Quality::kAssumed; }
  std::string_view type() const { return about ? std::string_view(about->type) : std::string_view(); }
  /// `light-1`
  std::string_view id() const { return std::string_view(key).substr(key.rfind('.') + 1); }
  /// `fridge` of `switch-fridge`.
  std::string_view instance() const { return id().substr(std::min(id().find('-') + 1, id().size())); }
  /// `rubicon/6541/wsn-1/7/sensor/light-1`, and what stands below: `/online`.
  std::string topic(std::string_view below = {}) const;
};

struct ByKey {
  bool operator()(const PointEntry* left, const PointEntry* right) const { return left->key < right->key; }
};

struct DeviceEntry {
  OwnerId island{};
  std::string prefix, network, id, key, topic;
  std::optional<model::DeviceDescription> about{};
  std::string status{};                            ///< unknown, reachable or unreachable
  std::set<PointEntry*, ByKey> points;             ///< sensors behind actuators and properties
  std::map<std::string, std::size_t> announced{};  ///< topics of discovery that stand at the broker, and hashes of them
  SteadyTime since{};
  bool dirty = false;
  bool lost = false;  ///< its island is
  std::optional<bool> online{};
  bool is_away() const { return lost || status == "unreachable"; }
};

struct NetworkEntry {
  OwnerId island{};
  std::string id, topic;
  bool works = false, dirty = false;
  bool lost = false;  ///< its island is
};

/// Addresses of the devices of a group, by the address of the group.
using Groups = std::map<std::string, std::vector<std::string>>;

struct IslandEntry {
  OwnerId id{};
  std::string name, prefix, version, topic;
  bool present = false, dirty = false;
  Timer forgets{};  ///< back: what it did not bring back; away: all of it
};

/// What points say of themselves: those that are described alike share one.
class Descriptions {
 public:
  /// nullptr: it is none.
  std::shared_ptr<const model::PointDescription> of(std::string_view text);

 private:
  static constexpr std::size_t kFew = 256;
  base::ByText<std::shared_ptr<const model::PointDescription>> by_text_;
  std::size_t most_ = kFew;  ///< beyond, those without a point are dropped
};

/// Of a network or a device among those of all islands: `6541:proxy.wsn-1.7`.
std::string name_of(OwnerId owner, std::string_view key);

/// What is mirrored: follows the tuples of the islands that the patterns select, without demand. What belongs to an
/// island that is away for longer than kOwnerGrace is *network-down*; what it does not bring back is forgotten, and so
/// is an island that does not come back.
class House {
 public:
  struct Callbacks {
    std::function<void(PointEntry&)> point;    ///< value or quality
    std::function<void(PointEntry&)> status;   ///< anything of its status
    std::function<void(DeviceEntry&)> device;  ///< description, status, points
    std::function<void(NetworkEntry&)> network;
    std::function<void(IslandEntry&)> island;
    std::function<void(PointEntry&)> point_gone;    ///< before it is destroyed
    std::function<void(DeviceEntry&)> device_gone;  ///< with its points
    std::function<void(DeviceEntry&)> renamed;      ///< before its topics change
    std::function<void(OwnerId island, const std::string& network)> network_gone;
    std::function<void(IslandEntry&)> island_gone;  ///< after its networks
    /// Whether a network with this property Scope::origin comes from where we show it.
    std::function<bool(std::string_view origin)> is_ours;
  };
  House(const BridgeHost& host, const Scope& scope, Callbacks calls);

  void start();
  PointEntry* find_by_topic(std::string_view topic);
  DeviceEntry* find_device(std::string_view topic);
  IslandEntry* find_island(OwnerId id);
  void each_device(const std::function<void(DeviceEntry&)>& visit);
  void each_network(const std::function<void(NetworkEntry&)>& visit);
  void each_island(const std::function<void(IslandEntry&)>& visit);
  /// The devices of a group that are there; empty for other devices.
  std::vector<DeviceEntry*> members_of(const DeviceEntry& group) const;
  /// The groups that have the device.
  std::vector<DeviceEntry*> groups_of(const DeviceEntry& member) const;
  bool selects_island(OwnerId id) const;
  /// All points of the device are described, or it is there for kComplete.
  bool is_complete(const DeviceEntry& device) const;
  static constexpr Duration kComplete = std::chrono::seconds(5);
  /// What an island that came back has not shown in this time, it does not have any longer.
  static constexpr Duration kReturn = std::chrono::seconds(60);
  /// An island that is away for this time is forgotten. Long, because Home Assistant removes its entities, with what
  /// people set for them: a site that is switched off for a holiday must find them again.
  static constexpr Duration kGoneForGood = std::chrono::hours(7 * 24);
  std::size_t devices() const { return devices_.size(); }
  std::size_t points() const { return points_.size(); }
  /// Where an island stands among the topics.
  std::string island_topic(OwnerId id) const;

 private:
  /// A point by owner and key.
  struct Place {
    OwnerId island{};
    std::string_view key;
    friend bool operator==(const Place&, const Place&) = default;
  };
  using PointPtr = std::unique_ptr<PointEntry>;
  static Place place_of(const Place& place) { return place; }
  static Place place_of(const PointPtr& point) { return {point->device->island, point->key}; }
  struct PlaceHash {
    using is_transparent = void;
    std::size_t operator()(const auto& one) const {
      return std::hash<std::string_view>()(place_of(one).key) ^ number(place_of(one).island);
    }
  };
  struct SamePlace {
    using is_transparent = void;
    bool operator()(const auto& left, const auto& right) const { return place_of(left) == place_of(right); }
  };

  using Take = void (House::*)(const Event&);
  std::vector<std::pair<std::string, Take>> takes(const model::NetworkKey& network) const;
  void look_again(OwnerId island, const model::NetworkKey& network);
  void valued(const Event& event);
  void stated(const Event& event);
  void described(const Event& event);
  void device_stated(const Event& event);
  void device_described(const Event& event);
  void line_stated(const Event& event);
  void origin_named(const Event& event);
  void grouped(const Event& event);
  std::vector<DeviceEntry*> find_addresses(const DeviceEntry& near, const std::vector<std::string>& addresses) const;
  void island_changed(OwnerId id);
  PointEntry* find_point(OwnerId island, std::string_view key);
  PointEntry* point_at(const TupleView& tuple, bool make);
  DeviceEntry* device_at(OwnerId island, std::string_view key, bool make);
  bool selected(OwnerId owner, std::string_view point_key) const;
  std::string topic_of(const DeviceEntry& device) const;
  void name_again(DeviceEntry& device);
  void lose(PointEntry& point);
  void forget_lost(OwnerId island);
  void forget_lost_origins(OwnerId island);
  void forget_island(OwnerId island);
  void forget_point(const PointEntry& point);
  void leave_topic(const DeviceEntry& device);
  void forget_device(const std::string& name);
  void forget_network(const std::string& name);

  const BridgeHost& host_;
  const Scope& scope_;
  Callbacks callbacks_;
  WallTime started_{};
  std::map<OwnerId, IslandEntry> islands_;
  std::map<std::string, NetworkEntry> networks_;                 ///< by owner and key
  std::map<std::string, std::unique_ptr<DeviceEntry>> devices_;  ///< by owner and key
  base::ByText<DeviceEntry*> by_topic_;
  std::unordered_set<PointPtr, PlaceHash, SamePlace> points_;
  PointEntry* recent_ = nullptr;  ///< the last that was found: value and status of a reading come one after the other
  Descriptions descriptions_;
  std::map<std::string, Groups> groups_;  ///< by owner and key of their network
  std::set<std::string> foreign_;         ///< owner and key of networks that come from where we show them
  std::vector<Handle> handles_;
};

}  // namespace rubicon::bridges
