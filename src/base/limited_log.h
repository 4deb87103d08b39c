#pragma once

#include <string>
#include <string_view>

#include "base/log.h"
#include "base/rate_limit.h"
#include "base/scheduler.h"

namespace rubicon::base {

/// A log for what may happen often: one line per subject and minute; the others are discarded. The scheduler must
/// outlive it.
class LimitedLog {
 public:
  LimitedLog(Log log, Scheduler& scheduler) : log_(std::move(log)), scheduler_(scheduler) {}

  /// False: discarded.
  bool debug(const std::string& subject, std::string_view text) {
    const bool allowed = allow(subject);
    if (allowed) log_.debug(text);
    return allowed;
  }
  /// False: discarded.
  bool info(const std::string& subject, std::string_view text) {
    const bool allowed = allow(subject);
    if (allowed) log_.info(text);
    return allowed;
  }
  /// False: discarded.
  bool warning(const std::string& subject, std::string_view text) {
    const bool allowed = allow(subject);
    if (allowed) log_.warning(text);
    return allowed;
  }
  /// False: discarded.
  bool error(const std::string& subject, std::string_view text) {
    const bool allowed = allow(subject);
    if (allowed) log_.error(text);
    return allowed;
  }
  /// The log without a limit, for rare lines.
  const Log& unlimited() const { return log_; }

 private:
  bool allow(const std::string& subject) { return limit_.allow(subject, scheduler_.now()); }

  Log log_;
  Scheduler& scheduler_;
  RateLimit limit_;
};

}  // namespace rubicon::base
