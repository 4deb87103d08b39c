#pragma once

#include "base/lifetime.h"
#include "base/scheduler.h"
#include "model/point_tuples.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// One set of another component's tuple, followed to its end: the owner's answer, and for a command what its status
/// tells then. Waits as long as the island says that each state may last, and `patience` longer for the news of it.
/// Ends when destroyed, without a call.
class Errand {
 public:
  Errand(Scheduler& scheduler, TupleSpace& space, OwnerId owner, std::string_view key, std::string_view value,
         OutcomeCall ended, Duration time_to_live, Duration patience, OutcomeCall under_way = {});

 private:
  void answered(const tuples::Reply& reply);
  void stated(const tuples::Event& event);
  void displaced(const model::Commander& by);
  void left();
  void wait(Duration longest);
  void unheard();
  void end();

  Scheduler& scheduler_;
  OwnerId self_;
  OwnerId owner_;  ///< who tells of it: another one when the device moved
  bool is_command_ = false;
  Outcome outcome_;
  OutcomeCall ended_, under_way_;
  Duration margin_;
  bool is_state_ = false;  ///< the point takes the newest command only (its description says so)
  bool seen_ = false;      ///< the status told of this command
  tuples::Handle status_, description_;
  Timer patience_, move_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::client
