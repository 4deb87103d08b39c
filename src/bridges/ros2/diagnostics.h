#pragma once

#include <string>

#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "bridges/house.h"
#include "bridges/ros2/node.h"
#include "bridges/ros2/ros2_bridge.h"

namespace rubicon::bridges::ros2 {

/// Levels of diagnostic_msgs/DiagnosticStatus.
enum class Level : std::uint8_t { kOk, kWarn, kError, kStale };
Level level_of(model::Quality quality);
/// The one of the two that tools show first: error, stale, warning, ok.
Level worse(Level one, Level other);

/// `/diagnostics`: a status for each network and device, at once for what changed, all each period; nothing while
/// nobody reads it.
class Diagnostics {
 public:
  /// Of a message, in bytes: what does not fit is in the next one. Of a value: what is longer is cut.
  static constexpr std::size_t kMaxMessage = std::size_t{256} << 10U, kMaxValue = 200;

  Diagnostics(const BridgeHost& host, const Options& options, House& house);

  /// nullptr: there is none any more.
  void attach(Node* node);
  void changed(const DeviceEntry& device);
  void networks_changed();
  void island_changed(const IslandEntry& island);
  void gone(DeviceEntry& device) { changed_.erase(&device); }
  void news(dds_entity_t endpoint);

 private:
  void tick();
  void say_changes();
  static std::string place_of(const IslandEntry* island, OwnerId id, const std::string& below);

  const BridgeHost& host_;
  const Options& options_;
  House& house_;
  Endpoint writer_;
  bool read_ = false;
  std::set<const DeviceEntry*> changed_;
  bool networks_changed_ = false;
  base::PacedCall soon_;
  Timer tick_;
};

}  // namespace rubicon::bridges::ros2
