#pragma once

#include <functional>
#include <optional>
#include <string>

#include "config/storage_config.h"
#include "history/store.h"
#include "transport/transports.h"

namespace rubicon::history {

struct ImportRules {
  std::vector<Pattern> patterns = config::usual_history();  ///< what to take
  std::vector<Pattern> exclude{};
  std::optional<WallTime> end{};  ///< all times are moved so that the recording ends then; nullopt = as they are
};

struct Imported {
  std::uint64_t records = 0;  ///< of the recording
  std::uint64_t points = 0;   ///< written
  std::uint64_t damage = 0;   ///< parts of the recording that could not be read
  std::uint64_t unfit = 0;    ///< values that do not fit their series
  WallTime first{}, last{};   ///< of the recording, as they were
};

/// Fills a history from a recording, as if it had run then; writes in batches. Errors: those of the file, and of the
/// store.
Result<Imported> import_recording(Store& store, transport::Transports& transports, const std::string& path,
                                  const ImportRules& rules);

}  // namespace rubicon::history
