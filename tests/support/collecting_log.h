#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "base/log.h"

namespace rubicon::support {

/// Keeps every line, for tests that ask what was said.
class CollectingLog final : public base::LogSink {
 public:
  void write(base::LogLevel, std::string_view who, std::string_view text) override {
    lines.push_back(std::string(who) + ": " + std::string(text));
  }
  bool contains(std::string_view part) const {
    return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.find(part) != line.npos; });
  }

  std::vector<std::string> lines;
};

}  // namespace rubicon::support
