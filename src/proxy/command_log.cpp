#include "proxy/command_log.h"

#include <fmt/format.h>

#include "rubicon/key.hpp"

namespace rubicon::proxy {

void CommandLog::ended(const Command& command, std::string_view how, std::string_view why) {
  const auto now = context_.clock.now().steady;
  if (begun_ == SteadyTime::min() || now - begun_ >= kWindow) {
    tell_left_out();
    begun_ = now;
    said_ = 0;
  }
  if (said_ >= kLines) {
    ++left_out_[std::string(how)];
    if (!end_.pending()) end_ = context_.scheduler.at(begun_ + kWindow, [this] { tell_left_out(); });
    return;
  }
  ++said_;
  const std::chrono::duration<double> took = now - command.accepted;
  context_.log.info(fmt::format("{} = {} by {}, id {}: {} after {:.2f} s{}{}", command.key, model::quoted(command.text),
                                command.commander, number(command.creator), how, took.count(), why.empty() ? "" : ": ",
                                why));
}

void CommandLog::tell_left_out() {
  end_.cancel();
  if (left_out_.empty()) return;
  std::uint64_t all = 0;
  std::string parts;
  for (const auto& [how, count] : left_out_) {
    all += count;
    parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", count, how);
  }
  left_out_.clear();
  context_.log.info(fmt::format("{} more commands ended within {} s: {}", all,
                                std::chrono::duration_cast<std::chrono::seconds>(kWindow).count(), parts));
}

}  // namespace rubicon::proxy
