#include "console/live_log.h"

#include <algorithm>
#include <utility>

namespace rubicon::console {

namespace {

base::LogLevel level_of(const std::string& word) {
  if (word == "debug") return base::LogLevel::kDebug;
  if (word == "warning") return base::LogLevel::kWarning;
  return word == "error" ? base::LogLevel::kError : base::LogLevel::kInfo;
}

}  // namespace

LiveLog::LiveLog(base::LogSink& behind, const std::string& level, const base::Scheduler& clock)
    : behind_(behind), clock_(clock), least_(level_of(level)), off_(level == "off") {}

void LiveLog::write(base::LogLevel level, std::string_view who, std::string_view text) {
  if (!held_) behind_.write(level, who, text);
  if (off_ || level < least_) return;
  const bool complaint = level >= base::LogLevel::kWarning;
  if (complaint) ++complaints_;
  if (complaint && held_) owed_.push_back({level, std::string(who), std::string(text.substr(0, kMostBytes))});
  if (owed_.size() > kKept) owed_.pop_front();
  keep({clock_.wall_now(), level, std::string(who) + ": " + std::string(text.substr(0, kMostBytes))});
}

void LiveLog::note(std::string text) {
  text.resize(std::min(text.size(), kMostBytes));
  keep({clock_.wall_now(), base::LogLevel::kInfo, std::move(text)});
}

void LiveLog::keep(Line line) {
  lines_.push_back(std::move(line));
  if (lines_.size() > kKept) lines_.pop_front();
}

void LiveLog::release() {
  held_ = false;
  for (const auto& line : std::exchange(owed_, {})) behind_.write(line.level, line.who, line.text);
}

}  // namespace rubicon::console
