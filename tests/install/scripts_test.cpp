#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "support/process.h"

namespace rubicon::install {
namespace {

/// Runs scripts/common.sh as ./run and ./test do, on a machine whose dpkg knows cmake only; nothing is installed.
support::Outcome on_a_fresh_machine(const std::string& command) {
  const auto folder = std::filesystem::temp_directory_path() / ("rubicon_scripts_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto dpkg = folder / "dpkg-query";
  std::ofstream(dpkg) << "#!/bin/sh\necho 'cmake install ok installed'\nexit 1\n";
  std::filesystem::permissions(dpkg, std::filesystem::perms::owner_all);
  const auto outcome = support::run_to_end(
      {"bash", "-c",
       "set -euo pipefail; PATH=" + folder.string() +
           ":$PATH; . " RUBICON_SOURCE_DIR "/scripts/common.sh; as_root() { echo \"as root: $*\"; }; " + command});
  std::filesystem::remove_all(folder);
  return outcome;
}

TEST(Scripts, WhatDpkgDoesNotKnowIsInstalled) {
  const auto outcome = on_a_fresh_machine("install_missing; echo went on");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors + outcome.output, testing::HasSubstr("libexpat1-dev"));
  EXPECT_THAT(outcome.errors + outcome.output, testing::Not(testing::HasSubstr(" cmake ")));
  EXPECT_THAT(outcome.errors + outcome.output, testing::HasSubstr("apt-get install"));
  EXPECT_THAT(outcome.output, testing::HasSubstr("went on"));
}

}  // namespace
}  // namespace rubicon::install
