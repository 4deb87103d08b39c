#pragma once

#include <map>
#include <string>

#include "proxy/command.h"
#include "proxy/proxy_context.h"

namespace rubicon::proxy {

/// One line at info for each accepted command, when it has ended: who, what, how, after how long, why. A flood of
/// commands does not become one of lines: beyond kLines a kWindow they are counted in one line by how they ended.
class CommandLog {
 public:
  static constexpr std::size_t kLines = 50;
  static constexpr Duration kWindow = std::chrono::seconds(10);

  explicit CommandLog(ProxyContext& context) : context_(context) {}
  ~CommandLog() { tell_left_out(); }
  CommandLog(const CommandLog&) = delete;
  CommandLog& operator=(const CommandLog&) = delete;

  /// `how` is its last state, or a word for the end of one that had none: `dropped`, `moved`.
  void ended(const Command& command, std::string_view how, std::string_view why);

 private:
  void tell_left_out();

  ProxyContext& context_;
  SteadyTime begun_ = SteadyTime::min();
  std::size_t said_ = 0;
  std::map<std::string, std::uint64_t, std::less<>> left_out_;  ///< by how they ended
  Timer end_;
};

}  // namespace rubicon::proxy
