#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/message.h"
#include "model/type_catalogue.h"

namespace rubicon::networks::log {

/// The last reading of each point in a part of a recording that is searched and not played, so that devices show the
/// state of the moment at which it goes on. Keeps no events: what happened before does not happen again. Holds as many
/// readings as the recording has points.
class LastReadings {
 public:
  explicit LastReadings(const TypeCatalogue& types) : types_(types) {}

  void joined(const std::string& device, const model::Join& join);
  void left(const std::string& device) { devices_.erase(device); }
  /// `when` is the user time of readings that have none; zero = they stay without.
  void keep(const std::string& device, const model::Updates& updates, WallTime when);
  /// What was kept, by device; nothing is kept any more.
  std::vector<std::pair<std::string, model::Body>> take();
  void clear();

 private:
  struct Device {
    std::set<model::PointId> events;
    std::map<model::PointId, model::Reading> last;
  };
  bool is_event(const Device& device, const model::PointId& point) const;

  const TypeCatalogue& types_;
  std::map<std::string, Device> devices_;
};

}  // namespace rubicon::networks::log
