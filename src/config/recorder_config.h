#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "rubicon/key.hpp"

namespace rubicon::config {

/// When a recording goes on in a new file, and how many old ones stay.
struct Rotation {
  std::optional<std::uint64_t> size = 100'000'000;  ///< bytes; nullopt = never by size
  std::optional<Duration> every = std::chrono::hours(24);
  std::optional<std::size_t> keep = 10;  ///< besides the file being written; nullopt = all

  friend bool operator==(const Rotation&, const Rotation&) = default;
};

/// One entry of `recorders:`.
struct RecorderSetup {
  std::string name;
  std::string file;  ///< as configured
  std::vector<Pattern> patterns;
  bool active = false;  ///< creates demand
  Duration minimum{0};  ///< at most one event of a tuple in this time
  Rotation rotation;
  int compression = 3;

  friend bool operator==(const RecorderSetup&, const RecorderSetup&) = default;
};

/// Reads `recorders:`; what is wrong stands in the reader's errors.
std::vector<RecorderSetup> read_recorders(ConfigReader& root);

}  // namespace rubicon::config
