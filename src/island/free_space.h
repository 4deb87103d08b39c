#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "base/scheduler.h"

namespace rubicon::island {

/// How much room the disks have that an island writes to. Looked up every ten seconds at most, and rounded down (to
/// 1 MB, above 1 GB to 100 MB), so that it changes seldom.
class FreeSpace {
 public:
  explicit FreeSpace(Scheduler& scheduler) : scheduler_(scheduler) {}

  /// Bytes that the user of this process may still write beside the file; nullopt where there is no such folder.
  std::optional<std::uint64_t> beside(const std::string& file);

 private:
  struct Known {
    SteadyTime looked{};
    std::optional<std::uint64_t> bytes;
  };
  Scheduler& scheduler_;
  std::map<std::string, Known> known_;  ///< by folder: those of the configuration
};

}  // namespace rubicon::island
