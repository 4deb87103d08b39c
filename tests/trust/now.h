#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "rubicon/time.hpp"

namespace rubicon::trust {

/// The time of these tests.
inline constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 23);

inline std::string content_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace rubicon::trust
