#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "support/process.h"

namespace rubicon::support {

inline nlohmann::json parsed(const std::optional<std::string>& line) {
  return line ? nlohmann::json::parse(*line, nullptr, false) : nlohmann::json();
}

/// One command and its answer, a line of JSON each; null when none comes. A tuple that it got is merged into the
/// answer.
inline nlohmann::json ask(Process& program, const std::string& command) {
  program.write(command + "\n");
  auto answer = parsed(program.line_with("\"ok\""));
  if (answer.contains("tuple")) answer.update(nlohmann::json(answer["tuple"]));
  return answer;
}

/// Asks again until the answer is as it should be.
template <class Holds>
testing::AssertionResult until(Process& program, const std::string& command,
                               std::chrono::steady_clock::duration patience, Holds holds) {
  using namespace std::chrono_literals;
  nlohmann::json answer;
  const auto end = std::chrono::steady_clock::now() + patience;
  for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(10ms)) {
    answer = ask(program, command);
    if (holds(answer)) return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << command << ": " << answer;
}

}  // namespace rubicon::support
