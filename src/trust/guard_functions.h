#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "rubicon/result.hpp"
#include "trust/guard/guard.h"
#include "trust/revoked_list.h"
#include "tuples/dds/dds_trust.h"

namespace rubicon::trust {

/// The path of the guard's library: $RUBICON_GUARD, else where the build or the installation has it, seen from the
/// program or library that this code is in.
std::string guard_path();

/// The functions of the guard in this process, once it is loaded. Cyclone DDS loads the same library: both see one
/// state.
class GuardFunctions {
 public:
  /// Loads the guard and keeps it for the life of the process. kIo with the reason of the linker. kUnsupported: it is
  /// of another version.
  Result<void> load(const std::string& path);
  bool loaded() const { return who_.load() != nullptr; }

  /// Thread-safe. nullopt: the guard is not loaded, does not know the peer, or says what no certificate of ours says.
  std::optional<tuples::Member> who(const tuples::dds::GuidPrefix& participant) const;
  void revoke(const RevokedList& list) const;
  /// Thread-safe: rubicon_guard_meets_revoked().
  bool meets_revoked() const;
  /// As DdsTrust::watch_refused(); of several objects in a process the last one hears, also when others end. Before or
  /// after load().
  void watch(tuples::dds::DdsTrust::Refused call);

  GuardFunctions() = default;
  GuardFunctions(const GuardFunctions&) = delete;
  GuardFunctions& operator=(const GuardFunctions&) = delete;
  ~GuardFunctions() { watch({}); }

 private:
  void begin_watch();

  std::atomic<decltype(&rubicon_guard_who)> who_ = nullptr;
  std::atomic<decltype(&rubicon_guard_revoke)> revoke_ = nullptr;
  std::atomic<decltype(&rubicon_guard_meets_revoked)> meets_revoked_ = nullptr;
  decltype(&rubicon_guard_watch) watch_ = nullptr;
  tuples::dds::DdsTrust::Refused refused_;  ///< changes only while the guard does not watch
};

}  // namespace rubicon::trust
