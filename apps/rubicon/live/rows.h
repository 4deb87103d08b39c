#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon/doctor/signs.h"
#include "client/names.h"
#include "model/point_tuples.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::cli::live {

struct LiveIsland {
  OwnerId id{};
  std::string name;  ///< empty while it is absent
  bool is_present = true;
};

struct LiveNetwork {
  std::string name, line, reason;
};

struct LiveDevice {
  std::string network, id, name, status, reason;
};

struct LivePoint {
  std::string id, value, unit, quality, command;
  WallTime heard{};  ///< zero = never
  double per_second = 0;
  std::string name{};  ///< that people gave it
};

/// What a live table shows, read from the copies that a component has of the tuples of islands. Things have their keys
/// with the owner in front as names: `6541:proxy.wsn-1`, `6541:proxy.wsn-1.7`, `6541:proxy.wsn-1.7.sensor.light-1`.
class LiveSource {
 public:
  /// `island` nullopt: of all. `space` must outlive it.
  LiveSource(const TupleSpace& space, std::optional<OwnerId> island, std::string prefix);

  /// By id; those that left are there until their copies end. Names of networks have their island in front from now on
  /// if there are several.
  const std::vector<LiveIsland>& look();
  std::vector<std::string> networks() const;
  LiveNetwork network(const std::string& key) const;
  /// By island, network and device; numbers in them count as numbers.
  std::vector<std::string> devices() const;
  LiveDevice device(const std::string& key) const;
  /// Of a device: sensors first, then actuators.
  std::vector<std::string> points(const std::string& device) const;
  LivePoint point(const std::string& key) const;

  struct Count {
    std::size_t devices = 0, reachable = 0;
  };
  Count count() const;
  /// The shortest words that name a point on the command line: `dummy-1.living.lamp-1`.
  std::string short_name(const std::string& point) const;
  /// A command line of `rubicon` that changes something, if there is anything to change.
  std::string command_to_try() const;

  /// A value was set.
  void count(OwnerId owner, std::string_view key, WallTime when);
  /// From now on points have the rate of the values that were counted since the last call.
  void end_round(Duration length);

 private:
  std::optional<tuples::TupleView> tuple(std::string_view name) const;
  std::string value(const std::string& name) const;
  std::string network_name(const std::string& key) const;
  model::PointDescription description(const std::string& point) const;
  void learn_names();

  const TupleSpace& space_;
  std::optional<OwnerId> island_;
  std::string prefix_;
  std::vector<LiveIsland> islands_;
  client::KnownNames names_;                  ///< of points
  std::map<OwnerId, std::string> overviews_;  ///< that they were learned from
  Rates rates_;
  std::map<std::string, double, std::less<>> per_second_;  ///< of the values that were set at all
};

/// Devices below their networks, or one list of all: by name, the last heard first, those whose values come most often
/// first, or those in trouble first.
enum class LiveSort : std::uint8_t { kNetwork, kName, kLatest, kBusiest, kTrouble };
inline constexpr int kLiveSorts = 5;
std::string_view to_string(LiveSort sort);

/// What of the islands is shown, and in which order.
struct LiveChoice {
  std::string filter;  ///< words that must all stand in a row or above it; case does not matter
  LiveSort sort = LiveSort::kNetwork;
  std::set<std::string> folded;  ///< keys of networks and devices; nothing below them is shown
};

struct LiveRow {
  enum class Kind : std::uint8_t { kNetwork, kDevice, kPoint };
  Kind kind = Kind::kPoint;
  std::string key;

  friend bool operator==(const LiveRow&, const LiveRow&) = default;
};

/// The rows of the whole table. Folds do not hide what a filter finds.
std::vector<LiveRow> live_rows(const LiveSource& source, const LiveChoice& choice);

}  // namespace rubicon::cli::live
