#pragma once

#include <deque>
#include <string>

#include "networks/log/recorded_keys.h"

namespace rubicon::networks::log {

/// Turns the records of one network into what its devices sent: descriptions become joins, values readings with their
/// user times; statuses only show whether a value was heard or stored from before. Bounded in memory. What the
/// constructor takes by reference must outlive it.
class DeviceReplay {
 public:
  static constexpr std::size_t kMaxDescription = 256 << 10;  ///< bytes
  static constexpr std::size_t kMaxDescriptions = 64 << 20;  ///< bytes of all of them

  /// `step` collects the messages; the caller takes them out.
  DeviceReplay(RecordedKeys& keys, ForeignTypes& types, WorkBudget& budget, RecordingFaults& faults, Step& step)
      : keys_(keys), types_(types), budget_(budget), faults_(faults), step_(step) {}

  /// Forgets what was played before: the recording starts again, or the recorder did. The devices stay until a snapshot
  /// shows that they are gone.
  void begin_session();
  void play(const recording::Record& record);
  /// Something was lost: the present snapshot does not show which devices are gone.
  void damaged() { snapshot_is_sound_ = false; }

  /// Devices wait for the end of a turn of the recorded loop.
  bool has_deferred() const { return !deferred_.empty(); }
  /// The record is of a later turn, and devices still wait for the end of the present turn.
  bool must_end_turn_before(const recording::Record& record) const {
    return record.seen != turn_ && has_deferred() && !in_snapshot_;
  }
  void end_turn() { turn_ended_ = true; }
  /// Does what the end of a turn or of a snapshot left to do. False: the budget is used up, call it again.
  bool run_pending();
  /// The step is large enough, or the work was.
  bool budget_used() const;

 private:
  void read_mark(const recording::Record& record);
  void complete_snapshot();
  void find_missing();
  void read_device(RecordedDevice& device, const recording::Record& record);
  void read_point(RecordedDevice& device, RecordedPoint& point, const recording::Record& record);
  void read_value(RecordedDevice& device, RecordedPoint& point, const recording::Record& record);
  void read_status(RecordedDevice& device, RecordedPoint& point, const recording::Record& record);
  void remove_value(RecordedDevice& device, RecordedPoint& point);
  void drop_description(RecordedDevice& device, std::size_t counted);
  void update_session(RecordedPoint& point) const;
  bool must_hold(const RecordedDevice& device, const RecordedPoint& point) const;
  void hold(RecordedDevice& device, RecordedPoint& point, Value value, const recording::Record& record);
  void release(RecordedDevice& device, RecordedPoint& point);

  void defer(RecordedDevice& device);
  void settle(RecordedDevice& device);
  bool reserve_description(std::size_t before, std::size_t after);
  void join_or_defer(RecordedDevice& device);
  void join(RecordedDevice& device);
  void leave(RecordedDevice& device, std::string reason);
  void add_reading(RecordedDevice& device, RecordedPoint& point, Value value, WallTime user_time);
  model::Updates& updates_for(const RecordedDevice& device, Kind kind);

  RecordedKeys& keys_;
  ForeignTypes& types_;
  WorkBudget& budget_;
  RecordingFaults& faults_;
  Step& step_;
  PointDescriptions descriptions_;

  WallTime turn_{};
  std::uint64_t session_ = 1;             ///< of the recorder
  std::deque<RecordedDevice*> deferred_;  ///< until the end of the turn
  bool turn_ended_ = false;               ///< the deferred devices come next,
  bool find_missing_ = false;             ///< then the search for those that the snapshot does not name,
  std::deque<RecordedDevice*> missing_;   ///< which leave
  std::size_t description_bytes_ = 0;
  std::size_t held_bytes_ = 0;
  std::uint64_t snapshot_ = 0;
  bool in_snapshot_ = false;
  bool snapshot_is_sound_ = false;
  WallTime snapshot_since_{};
};

}  // namespace rubicon::networks::log
