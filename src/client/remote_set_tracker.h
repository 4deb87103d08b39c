#pragma once

#include "base/scheduler.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// Follows one remote set until its outcome is known. For a command with states that is the final state in the status
/// of its point, else the owner's reply. Commands have states if their tuple is one of those of islands, or if its
/// owner describes the point (`<point>.description`). Waits as long as the island says that each state may last, and
/// `patience` longer for the news. `replied` receives the owner's reply, before or after the first state. Destruction
/// ends it without a call.
class RemoteSetTracker {
 public:
  RemoteSetTracker(Scheduler& scheduler, TupleSpace& space, OwnerId owner, std::string_view key, std::string_view value,
                   OutcomeCall ended, Duration time_to_live, Duration patience, OutcomeCall under_way = {},
                   tuples::ReplyCall replied = {}, const tuples::SetOptions& options = {},
                   tuples::ReplyCall noted = {});

  std::uint64_t request() const { return outcome_.request; }

 private:
  void watch_point(TupleSpace& space, const model::PointKey& point);
  void answered(const tuples::Reply& reply);
  void end_without_states();
  void status_changed(const tuples::Event& event);
  void superseded_by(const model::Commander& by);
  void device_left();
  void wait(Duration longest);
  void time_out();
  void end();

  Scheduler& scheduler_;
  OwnerId self_;
  OwnerId owner_;  ///< whose status reports the command; changes when the device moves to another island
  bool is_command_ = false;
  bool has_states_ = false;    ///< as far as is known
  bool all_described_ = true;  ///< a description would have arrived by now
  bool applied_ = false;
  Outcome outcome_;
  OutcomeCall ended_, on_progress_;
  tuples::ReplyCall replied_;
  Duration margin_;
  bool is_state_ = false;  ///< by its description, the point executes the newest command only
  bool seen_ = false;      ///< the status has named this command
  tuples::Handle status_, description_;
  Timer timeout_, move_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::client
