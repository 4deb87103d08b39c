#include "proxy/command_log.h"

#include <fmt/format.h>

#include "rubicon/key.hpp"

namespace rubicon::proxy {

void CommandLog::ended(const Command& command, std::string_view how, std::string_view why) {
  const auto now = context_.clock.now().steady;
  if (begun_ == SteadyTime::min() || now - begun_ >= kWindow) {
    log_omitted();
    begun_ = now;
    logged_ = 0;
  }
  if (logged_ >= kLines) {
    ++omitted_[std::string(how)];
    if (!end_.pending()) end_ = context_.scheduler.at(begun_ + kWindow, [this] { log_omitted(); });
    return;
  }
  ++logged_;
  const std::chrono::duration<double> took = now - command.accepted;
  context_.commands.info(fmt::format("{} = {} by {}, id {}: {} after {:.2f} s{}{}", command.key,
                                     model::quoted(command.text), command.commander, number(command.creator), how,
                                     took.count(), why.empty() ? "" : ": ", why));
}

void CommandLog::log_omitted() {
  end_.cancel();
  if (omitted_.empty()) return;
  std::uint64_t all = 0;
  std::string parts;
  for (const auto& [how, count] : omitted_) {
    all += count;
    parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", count, how);
  }
  omitted_.clear();
  context_.commands.info(fmt::format("{} more commands ended within {} s: {}", all,
                                     std::chrono::duration_cast<std::chrono::seconds>(kWindow).count(), parts));
}

}  // namespace rubicon::proxy
