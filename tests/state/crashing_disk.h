#pragma once

#include <cstdint>

namespace rubicon::state {

/// What happens at one of the operations that change files: writes, truncations, syncs and deletions, counted from 1.
struct CrashPlan {
  enum class Loss {
    kProcess,   ///< the process dies before the operation; the disk gets everything before it
    kUnsynced,  ///< the power fails: nothing is left of what was not synced
    kSome,      ///< the power fails: of what was not synced any sectors of 512 bytes are left
  };
  std::int64_t operation = 0;
  Loss loss = Loss::kProcess;
  std::uint32_t seed = 0;
};

/// Puts a disk below SQLite that ends the process with kCrashed as planned; without an operation it only forgets to
/// wait for the real one. Again: another plan, counting from the start.
void install_crashing_disk(const CrashPlan& plan);
void remove_crashing_disk();
inline constexpr int kCrashed = 77;

/// Operations so far.
std::int64_t disk_operations();

}  // namespace rubicon::state
