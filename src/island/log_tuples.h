#pragma once

#include <string>

#include "base/paced_call.h"
#include "island/log_lines.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// Publishes the last lines of a log as one tuple, at most four times a second, and only while a component subscribes
/// to it. An active subscription gets the present lines at once, a passive one within a second after the next line.
class LogTuples {
 public:
  /// Everything must outlive it.
  LogTuples(Scheduler& scheduler, TupleSpace& space, std::string key, LogLines& lines);
  ~LogTuples() { lines_.on_line({}); }
  LogTuples(const LogTuples&) = delete;
  LogTuples& operator=(const LogTuples&) = delete;

 private:
  void publish_if_wanted();
  void publish();

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string key_;
  LogLines& lines_;
  base::PacedCall publish_;
  Timer look_again_;
  tuples::Handle demand_;
};

}  // namespace rubicon::island
