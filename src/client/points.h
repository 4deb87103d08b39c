#pragma once

#include <array>
#include <map>
#include <set>
#include <tuple>

#include "base/scheduler.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// The content of a `<prefix>.<network>.<device>.description`. kInvalid: the key or the JSON is not one.
Result<Device> device_from(OwnerId island, std::string_view key, std::string_view description);
bool fits(const DeviceQuery& query, const Device& device);
/// The same of a description whose JSON was not read, at the cost of a search in it: false only if the device does not
/// fit.
bool may_fit(const DeviceQuery& query, std::string_view key, std::string_view description);

/// Follows the devices of all islands by their descriptions and statuses, and the lines of their networks, without
/// creating demand.
class DeviceWatch {
 public:
  DeviceWatch(TupleSpace& space, DeviceQuery query, DeviceCall call);

 private:
  using Name = std::tuple<OwnerId, std::string>;  ///< island, key of the device
  struct Entry {
    std::optional<Device> device;
    DeviceCondition condition;
    bool reported = false;
  };
  using Entries = std::map<Name, Entry>;
  void described(const tuples::Event& event);
  void stated(const tuples::Event& event);
  void line_stated(const tuples::Event& event);
  void report(Entry& entry);
  void forget(const Name& name);

  DeviceQuery query_;
  DeviceCall call_;
  Entries entries_;
  std::map<Name, LineStatus> lines_;  ///< by island and key of the network
  tuples::Handle lines_watch_, descriptions_, statuses_;
};

/// The tuples that make up points.
struct PointPatterns {
  Pattern values, statuses, descriptions, lines;

  std::array<const Pattern*, 4> all() const { return {&values, &statuses, &descriptions, &lines}; }
};
/// kInvalid unless `points` is a key of five parts.
Result<PointPatterns> point_patterns(const Pattern& points);

/// `proxy.wsn-1.status` of `proxy.wsn-1.7.sensor.light-1.value`.
std::string line_key(std::string_view key);

/// Takes type and unit from the `.description` of a point.
void describe(Point& point, std::string_view description);
/// Shows a point of a lost island as network-down.
void hide_behind_lost_island(Point& point);

/// The devices that match among the tuples: one for each description, still without the statuses of device and line.
std::vector<Device> described_devices(const std::vector<Tuple>& tuples, const DeviceQuery& query);
/// Gives them the statuses that are among the tuples.
void add_states(std::vector<Device>& devices, const std::vector<Tuple>& tuples);
/// Both.
std::vector<Device> devices_from(const std::vector<Tuple>& tuples, const DeviceQuery& query);
/// One network for each status of a line among the tuples, with the devices and properties among them.
std::vector<Network> networks_from(const std::vector<Tuple>& tuples);
/// The order of devices in lists: reachable ones first (docs/cli.md).
bool listed_before(const Device& a, const Device& b);

/// Follows points: the tuples of one belong together, so they are reported together, at the end of a turn. Ends when
/// destroyed, without a call.
class PointWatch {
 public:
  PointWatch(Scheduler& scheduler, TupleSpace& space, const PointPatterns& patterns, const Flow& flow, PointCall call);

 private:
  using Name = std::pair<OwnerId, std::string>;  ///< owner, key of the point (or of the status of a line)
  struct Entry {
    Point point;
    bool has_value = false;
    bool fresh = false;  ///< its value was set and not reported yet
    bool reported = false;
    PointStatus shown_status;  ///< as reported last
    LineStatus shown_line;
    std::optional<SteadyTime> improved_at;  ///< when its quality became good; its value may be held back by the flow
  };
  using Entries = std::map<Name, Entry>;

  void valued(const tuples::Event& event);
  void stated(const tuples::Event& event);
  void described(const tuples::Event& event);
  void line_stated(const tuples::Event& event);
  void arrived(OwnerId owner);
  void peer_changed(OwnerId owner, tuples::PeerEvent event);
  void note_if_lost(const tuples::TupleView& tuple);
  void forget_lost(OwnerId owner);
  void touch(const Name& name);
  void settle_at(SteadyTime when);
  void settle();
  /// False: it has to wait.
  bool report(const Name& name, Entry& entry);
  bool complete(OwnerId owner) const;
  Point shown(const Name& name, const Entry& entry) const;

  Scheduler& scheduler_;
  TupleSpace& space_;
  Duration hold_;  ///< how long a point that became good waits for the value that the flow holds back
  PointCall call_;
  Entries entries_;
  std::map<Name, LineStatus> lines_;
  std::set<Name> touched_;
  std::map<OwnerId, std::size_t> arrived_;  ///< how many of the four snapshots of an owner are here
  std::set<OwnerId> lost_;
  Timer timer_;
  SteadyTime settle_at_{};  ///< of the timer, while it is pending
  std::vector<tuples::Handle> handles_;
};

}  // namespace rubicon::client
