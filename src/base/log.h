#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "base/scheduler.h"
#include "rubicon/time.hpp"

namespace rubicon::base {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// Receives log lines: standard error in the daemon, a vector in tests.
class LogSink {
 public:
  virtual ~LogSink() = default;
  virtual void write(LogLevel level, std::string_view who, std::string_view text) = 0;
};

/// A log with a name, which writes to a sink; cheap to copy. The sink must outlive it.
class Log {
 public:
  Log(LogSink& sink, std::string who) : sink_(&sink), who_(std::move(who)) {}

  void debug(std::string_view text) const { sink_->write(LogLevel::kDebug, who_, text); }
  void info(std::string_view text) const { sink_->write(LogLevel::kInfo, who_, text); }
  void warning(std::string_view text) const { sink_->write(LogLevel::kWarning, who_, text); }
  void error(std::string_view text) const { sink_->write(LogLevel::kError, who_, text); }

 private:
  LogSink* sink_;
  std::string who_;
};

/// Discards everything.
class NullLogSink final : public LogSink {
 public:
  void write(LogLevel, std::string_view, std::string_view) override {}
};

}  // namespace rubicon::base

namespace rubicon {

using base::Log;
using base::LogSink;

}  // namespace rubicon

namespace rubicon::base {

/// Allows one log line per subject and minute, and counts the suppressed ones. Bounded: beyond 1024 subjects in
/// a minute all new ones share one limit.
class RateLimit {
 public:
  explicit RateLimit(Duration period = std::chrono::minutes(1)) : period_(period) {}

  bool allow(const std::string& subject, SteadyTime now);
  std::uint64_t swallowed() const { return swallowed_; }

 private:
  Duration period_;
  std::unordered_map<std::string, SteadyTime> last_;
  SteadyTime cleaned_{};
  std::uint64_t swallowed_ = 0;
};

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

// Secrets in texts that all components may read: the configuration in force, the lines of the log.

inline constexpr std::string_view kMasked = "****";

/// Whether an option of this name holds a secret: `password`, `api-key`, `web.token`. The path of a file and the name
/// of an environment variable (`password-file`, `password-env`) are none.
bool names_secret(std::string_view option);

/// The text with `****` for the password of each URL, what follows `Bearer`, and the value behind each name of a secret
/// (`password=...`, `token: ...`), up to a blank, a comma, a quote or a bracket.
std::string masked(std::string_view text);

}  // namespace rubicon::base
