#pragma once

#include <map>
#include <set>

#include "base/scheduler.h"
#include "client/points.h"

namespace rubicon::client {

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
