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

inline constexpr std::uint64_t kMinHistory = 1'000'000;  ///< bytes
inline constexpr Duration kMinRaw = std::chrono::hours(1);

/// The values of all sensors, actuators and properties of devices.
std::vector<Pattern> usual_history();

/// `history:`. Ages are those of values, sizes those of the file.
struct HistorySetup {
  std::string file{};                                                ///< as configured
  std::vector<Pattern> patterns = usual_history();                   ///< tuples to keep
  std::vector<Pattern> exclude{};                                    ///< but not these
  Duration minimum = std::chrono::seconds(1);                        ///< at most one point of a series in this time
  double dead_band = 0;                                              ///< smaller changes than this are not kept
  std::optional<Duration> raw = std::chrono::hours(30 * 24);         ///< how long each value stays; nullopt = always
  std::optional<Duration> hours = std::chrono::hours(2 * 365 * 24);  ///< how long the summaries of hours stay
  std::uint64_t size = 8'000'000'000;                                ///< bytes of the file

  friend bool operator==(const HistorySetup&, const HistorySetup&) = default;
};

/// Reads `history:`; nullopt if there is none. What is wrong stands in the reader's errors.
std::optional<HistorySetup> read_history(ConfigReader& root);

}  // namespace rubicon::config
