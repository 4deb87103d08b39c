#pragma once

#include <optional>
#include <string>
#include <vector>

#include "motes/mote_units.h"
#include "network/network.h"
#include "networks/log/csv_mapping.h"

namespace rubicon::networks::log {

/// The options of a `type: log` network.
struct LogOptions {
  enum class End { kHold, kLeave, kStop };
  /// kDetect: a recording of our own or packets, as the beginning of the first file shows.
  enum class Format { kDetect, kPackets, kCsv, kTuples };

  std::vector<std::string> files;  ///< as configured
  bool one_file = true;            ///< given as `file`, not as `files`
  std::string directory;           ///< relative paths start here
  double speed = 1;                ///< 0 = as fast as possible
  bool loop = false;
  Duration start = Duration::zero();
  std::optional<Duration> longest_gap;
  std::optional<Duration> between_files;
  End end = End::kHold;
  Duration deadline = std::chrono::minutes(1);  ///< after this silence a recorded sensor is stale; 0 = never
  bool recorded_times = true;                   ///< the user time of values is that of the recording, not of the replay
  Format format = Format::kDetect;
  std::optional<CsvMapping> csv;  ///< of kCsv
  std::string network;            ///< the one to be played of a recording of our own; empty = the only one
  motes::Calibration calibration;
};

/// Reads the options; mistakes are added to the reader's errors.
LogOptions read_log_options(const network::NetworkConfig& config);

}  // namespace rubicon::networks::log
