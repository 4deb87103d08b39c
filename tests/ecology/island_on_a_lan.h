#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "ecology/lan.h"
#include "support/process.h"

namespace rubicon::ecology {

inline const std::string kDaemonProgram = RUBICON_BINARY_DIR "/bin/rubicon-proxy";
inline const std::string kToolProgram = RUBICON_BINARY_DIR "/bin/rubicon";
/// A lamp, and a lock.
inline constexpr const char* kLamp = "1:proxy.dummy-1.den.actuator.switch-1.";
inline constexpr const char* kLock = "1:proxy.dummy-1.den.actuator.switch-2.";

/// Host 0 of a LAN has an island with a lamp and a lock; host 1 is that of somebody else.
class IslandOnALan : public testing::Test {
 protected:
  using Outcome = support::Outcome;
  using Process = support::Process;

  void SetUp() override;
  void TearDown() override;

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const;
  /// `home.yaml`; `more` are further sections.
  void configure(const std::string& tuples, const std::string& more = "") const;

  /// `rubicon` on host 1, by DDS.
  Outcome other(std::vector<std::string> words) const;
  /// `rubicon` on the host of the island, in its folder.
  Outcome here(std::vector<std::string> words) const;
  std::unique_ptr<Process> start(int host, std::vector<std::string> words) const;
  /// Ready when its shell answered. `before`: what runs the program.
  void start_island(const std::vector<std::string>& before = {});

  Lan lan_{2};
  std::filesystem::path folder_;
  std::unique_ptr<Process> island_;
};

/// Waits until the standard error of a program has the text (a minute at most).
bool says(support::Process& program, const std::string& text);

}  // namespace rubicon::ecology
