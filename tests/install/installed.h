#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/process.h"

namespace rubicon::install {

using support::Outcome;
using support::Process;

/// What `cmake --install` puts into an empty prefix; made once a program and removed at its end.
class Installed {
 public:
  static const Installed& get();
  ~Installed();

  const std::filesystem::path& prefix() const { return prefix_; }
  /// Beside the prefix, for what tests build and write.
  const std::filesystem::path& workshop() const { return workshop_; }
  const Outcome& outcome() const { return outcome_; }
  std::string daemon() const { return prefix_ / "bin/rubicon-proxy"; }

  /// Runs a shell command line to its end, with the installed package where the loader and pkg-config look.
  Outcome shell(const std::string& line) const;

 private:
  Installed();

  std::filesystem::path root_, prefix_, workshop_;
  Outcome outcome_;
};

std::string read_text(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);

/// An island with one simulated room, on DDS.
std::string sample_island(int id);

}  // namespace rubicon::install
