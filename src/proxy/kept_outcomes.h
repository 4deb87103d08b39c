#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>

#include "base/deadline.h"
#include "model/point_tuples.h"
#include "proxy/command.h"

namespace rubicon::proxy {

/// How the commands of a point ended that its status shows no more, because a newer one came: for a while the status
/// has them beside it, so that each commander finds its own. Several may end between two deliveries of a status.
class KeptOutcomes {
 public:
  /// Of a point, and in all; beyond them the oldest are forgotten, or none is kept.
  static constexpr std::size_t kMaxPerPoint = 256, kMaxInAll = 10'000;
  /// Of the texts of a point; so much stands in each status for a while.
  static constexpr std::size_t kMaxBytes = std::size_t{32} * 1024;
  static constexpr Duration kKept = std::chrono::seconds(10);
  /// Longer reasons are cut, in bytes.
  static constexpr std::size_t kMaxReason = 200;

  using Place = std::pair<DeviceNumber, PointNumber>;
  /// The text that the status of the point has to show from now on.
  using Changed = std::function<void(const Place& place, const std::string& text)>;

  KeptOutcomes(Scheduler& scheduler, Changed changed) : scheduler_(scheduler), changed_(std::move(changed)) {}

  /// The status shows this command now, with its state. Calls Changed if it replaces another one that had ended.
  void shown(const Command& command, bool is_final);
  void forget(const Place& place);
  void forget(DeviceNumber device);

 private:
  struct Kept {
    model::CommandOutcome outcome;
    SteadyTime since{};
  };
  struct OfPoint {
    Kept current;  ///< the one that the status shows
    bool is_final = false;
    std::deque<Kept> ended;  ///< oldest first
    std::size_t bytes = 0;
  };
  using Points = std::map<Place, OfPoint>;

  void drop_oldest(OfPoint& of);
  void keep(OfPoint& of);
  void tell(const Place& place, const OfPoint& of) const;
  void prune();

  Scheduler& scheduler_;
  Changed changed_;
  Points points_;
  std::size_t count_ = 0;  ///< of all `ended`
  base::Deadline next_{scheduler_, [this] { prune(); }};
};

}  // namespace rubicon::proxy
