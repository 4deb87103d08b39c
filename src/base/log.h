#pragma once

#include <string>
#include <string_view>

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
