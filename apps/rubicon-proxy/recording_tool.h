#pragma once

#include <functional>
#include <optional>
#include <string>

#include "rubicon/key.hpp"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::daemon {

/// What `rubicon-proxy recording FILE info|export` was asked for.
struct RecordingOptions {
  std::string file;
  std::string action = "info";
  bool jsonl = false;   ///< JSON lines; else CSV
  std::string pattern;  ///< empty = everything
  std::string out;      ///< a file that must not be there; empty = standard output
};

/// Takes text piece by piece; an error ends the work.
using WriteText = std::function<Result<void>(std::string_view text)>;

/// Describes the content of a recording and its damage. kInvalid if the file is not a recording.
Result<void> describe_recording(transport::Transports& transports, const std::string& file, const WriteText& write);

/// One line a record (docs/recording.md); marks are left out. `damaged` is called for each damaged place.
Result<void> export_recording(transport::Transports& transports, const RecordingOptions& options,
                              const WriteText& write, const std::function<void(std::string_view)>& damaged);

/// The program's subcommand; its exit code.
int recording(const RecordingOptions& options);

}  // namespace rubicon::daemon
