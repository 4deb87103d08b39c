#pragma once

#include <map>
#include <string>

#include "proxy/command.h"
#include "proxy/proxy_context.h"

namespace rubicon::proxy {

/// Logs one line at info for each accepted command when it ends: commander, value, final state, duration, reason. More
/// than kLines per kWindow are only counted, in one line by final state.
class CommandLog {
 public:
  static constexpr std::size_t kLines = 50;
  static constexpr Duration kWindow = std::chrono::seconds(10);

  explicit CommandLog(ProxyContext& context) : context_(context) {}
  ~CommandLog() { log_omitted(); }
  CommandLog(const CommandLog&) = delete;
  CommandLog& operator=(const CommandLog&) = delete;

  /// `how` is the final state, or `dropped` or `moved` for a command that ended without one.
  void ended(const Command& command, std::string_view how, std::string_view why);

 private:
  void log_omitted();

  ProxyContext& context_;
  SteadyTime begun_ = SteadyTime::min();
  std::size_t logged_ = 0;
  std::map<std::string, std::uint64_t, std::less<>> omitted_;  ///< by final state
  Timer end_;
};

}  // namespace rubicon::proxy
