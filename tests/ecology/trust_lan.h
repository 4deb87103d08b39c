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
inline constexpr const char* kLamp = "den.switch-1";
/// The same without a search by name.
inline constexpr const char* kLampCommand = "1:proxy.dummy-1.den.actuator.switch-1.command";
inline constexpr const char* kLampValue = "1:proxy.dummy-1.den.actuator.switch-1.value";

/// By DDS alone: on a host its folder says who takes part. Host 0 has the authority and an island with a lamp; host 1
/// is that of a person.
class TrustOnALan : public testing::Test {
 protected:
  using Outcome = support::Outcome;
  using Process = support::Process;

  explicit TrustOnALan(int hosts = 2) : lan_(hosts) {}
  void SetUp() override;
  void TearDown() override;

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string text_in(const std::string& name) const;
  void write(const std::string& name, const std::string& text) const;
  /// `home.yaml`; `more` are further sections.
  void configure(const std::string& more, const std::string& tuples = "interfaces: [cable], lease: 500ms") const;

  /// `rubicon` on a host.
  Outcome on(int host, std::vector<std::string> words, const std::string& input = {}) const;
  /// `rubicon trust` on the host with the authority.
  Outcome authority(std::vector<std::string> words) const;
  /// `rubicon` on host 0 as the member `local`.
  Outcome local(std::vector<std::string> words) const;
  /// `rubicon` on host 1 as the member `desk`.
  Outcome person(std::vector<std::string> words, const std::string& input = {}) const;

  void make_realm() const;
  /// What another host needs: add, carry the file, join. `more` are options of `add`.
  void add_member(const std::string& name, int host, const std::vector<std::string>& more) const;
  /// The realm, and the member `desk` on host 1.
  void add_desk(const std::string& role) const;

  /// A program on a host. An island is ready when its shell answered.
  std::unique_ptr<Process> start(int host, std::vector<std::string> words) const;
  std::unique_ptr<Process> island_on(int host, const std::string& configuration,
                                     const std::vector<std::string>& before = {}) const;
  void start_island(const std::vector<std::string>& before = {}) { island_ = island_on(0, "home.yaml", before); }
  /// Runs `home.yaml` to its end, for starts that fail.
  Outcome run_island(const std::vector<std::string>& before = {}) const;

  Lan lan_;
  std::filesystem::path folder_;
  std::unique_ptr<Process> island_;
};

/// Waits until the standard error of a program has the text so many times (a minute at most).
bool says(support::Process& program, const std::string& text, int times = 1);

}  // namespace rubicon::ecology
