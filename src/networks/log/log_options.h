#pragma once

#include <optional>
#include <string>
#include <vector>

#include "motes/mote_units.h"
#include "network/network.h"
#include "networks/log/csv_mapping.h"

namespace rubicon::networks::log {

/// What a `type: log` network is told in the configuration.
struct LogOptions {
  enum class End { kHold, kLeave, kStop };
  /// kFound: what the beginning of the first file says, a recording of our own or packets.
  enum class Format { kFound, kPackets, kCsv, kTuples };

  std::vector<std::string> files;  ///< as configured
  bool one_file = true;            ///< they stand in `file`, else in `files`
  std::string directory;           ///< where relative paths start
  double speed = 1;                ///< 0 = as fast as possible
  bool loop = false;
  Duration start = Duration::zero();
  std::optional<Duration> longest_gap;
  std::optional<Duration> between_files;
  End end = End::kHold;
  Duration deadline = std::chrono::minutes(1);  ///< longest silence of a recorded sensor before it is stale; 0 = never
  bool recorded_times = true;  ///< user time of values: when they were recorded, not when they are replayed
  Format format = Format::kFound;
  std::optional<CsvMapping> csv;  ///< of kCsv
  std::string network;            ///< of a recording of our own: which one is played; empty = the only one
  motes::Calibration calibration;
};

/// Reads the options; what is wrong stands in the reader's errors.
LogOptions read_log_options(const network::NetworkConfig& config);

}  // namespace rubicon::networks::log
