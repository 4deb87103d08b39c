#include "island/log_lines.h"

#include <algorithm>

#include "base/masked.h"
#include "base/printable.h"
#include "model/json_members.h"

namespace rubicon::island {

namespace {

std::string_view word_of(base::LogLevel level) {
  switch (level) {
    case base::LogLevel::kDebug: return "debug";
    case base::LogLevel::kInfo: return "info";
    case base::LogLevel::kWarning: return "warning";
    case base::LogLevel::kError: break;
  }
  return "error";
}

/// At most so many bytes, cut after a character.
std::string cut(std::string_view text, std::size_t most) {
  return std::string(text.substr(0, base::utf8_prefix(text.substr(0, most))));
}

}  // namespace

void LogLines::write(base::LogLevel level, std::string_view who, std::string_view text) {
  behind_.write(level, who, text);
  if (level < least_) return;
  // The mask comes before the cut: half a password would not be recognized behind it.
  lines_.push_back({++written_, clock_.wall_now(), level, cut(base::one_line(who), kMostSubject),
                    cut(base::masked(base::one_line(text)), kMostText)});
  if (lines_.size() > kKept) lines_.pop_front();
  if (call_) call_();
}

std::string LogLines::json() const {
  auto list = nlohmann::ordered_json::array();
  for (const auto& line : lines_) {
    list.push_back({{"number", line.number},
                    {"time", model::seconds_json(line.time)},
                    {"level", word_of(line.level)},
                    {"subject", line.subject},
                    {"text", line.text}});
  }
  return model::dump(list);
}

}  // namespace rubicon::island
