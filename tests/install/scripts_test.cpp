#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "support/folder.h"
#include "support/process.h"
#include "support/terminal.h"

namespace rubicon::install {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

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
           ":$PATH; . " RUBICON_SOURCE_DIR
           "/scripts/common.sh; root_command() { echo fake_root; }; fake_root() { echo \"as root: $*\"; }; " +
           command});
  std::filesystem::remove_all(folder);
  return outcome;
}

std::vector<std::string> packages(const std::string& list) {
  std::ifstream file(RUBICON_SOURCE_DIR "/scripts/packages-" + list + ".txt");
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && !line.starts_with("#")) names.push_back(line);
  }
  return names;
}

TEST(Scripts, WhatDpkgDoesNotKnowIsInstalled) {
  const auto outcome = on_a_fresh_machine("install_missing run; echo went on");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors + outcome.output, HasSubstr("libexpat1-dev"));
  EXPECT_THAT(outcome.errors + outcome.output, Not(HasSubstr(" cmake ")));
  EXPECT_THAT(outcome.errors + outcome.output, HasSubstr("apt-get install"));
  EXPECT_THAT(outcome.output, HasSubstr("went on"));
}

TEST(Scripts, WhatRunsApartGetsNoSignalsOfTheTerminal) {
  const auto outcome = on_a_fresh_machine(
      "apart sleep 100 >/dev/null & there=$!; until grep -q sleep /proc/$there/comm; do sleep 0.01; done; "
      "session() { cut -d' ' -f6 /proc/$1/stat; }; [ \"$(session $there)\" = $there ] && [ \"$(session $$)\" != $there "
      "] && "
      "echo apart; kill $there");
  EXPECT_THAT(outcome.output, HasSubstr("apart")) << outcome.errors;
}

TEST(Scripts, RunningInstallsNoTestToolsAndNoServices) {
  const auto to_run = on_a_fresh_machine("install_missing run");
  for (const auto& tool : packages("test")) EXPECT_THAT(to_run.errors, Not(HasSubstr(" " + tool + " "))) << tool;
  const auto to_test = on_a_fresh_machine("install_missing run test");
  EXPECT_THAT(to_test.errors, AllOf(HasSubstr(" knxd "), HasSubstr(" libgtest-dev "), HasSubstr(" g++ ")));
}

TEST(Scripts, EachPackageIsListedOnce) {
  auto all = packages("run");
  EXPECT_FALSE(all.empty());
  for (const auto* list : {"test", "package", "python", "root"}) {
    for (const auto& one : packages(list)) all.push_back(one);
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
}

TEST(Scripts, WithoutRootTheCommandForRootIsShown) {
  const auto outcome = on_a_fresh_machine("root_command() { echo false; }; install_missing run; echo went on");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("only root can install them. As root, run:"));
  EXPECT_THAT(outcome.errors, HasSubstr("\napt-get install --no-install-recommends cyclonedds-dev "));
  EXPECT_THAT(outcome.errors, Not(HasSubstr("apt-get update failed")));
  EXPECT_THAT(outcome.output, Not(HasSubstr("went on")));
}

TEST(Scripts, WhatAptCouldNotDoIsSaid) {
  for (const std::string step : {"update", "install"}) {
    const auto outcome =
        on_a_fresh_machine("fake_root() { [[ \" $* \" != *' " + step + " '* ]]; }; install_missing run; echo went on");
    EXPECT_EQ(outcome.code, 1) << step;
    EXPECT_THAT(outcome.errors, HasSubstr("apt-get " + step + " failed; it says above why."));
    EXPECT_THAT(outcome.errors, HasSubstr("\napt-get install --no-install-recommends cyclonedds-dev "));
    EXPECT_THAT(outcome.errors, Not(HasSubstr("only root"))) << step;
    EXPECT_THAT(outcome.output, Not(HasSubstr("went on"))) << step;
  }
}

TEST(Scripts, TheFirstBuildSaysHowLongItTakes) {
  const std::string slow = "root=$PWD/none; yardstick() { echo 1000; }; jobs() { echo 2; }; ";
  const auto first =
      on_a_fresh_machine(slow + "expect_minutes; [ $((expected - $(date +%s))) -gt 60 ] && time_left; echo");
  EXPECT_THAT(first.errors, HasSubstr("the first build takes about 2 min on this machine; later ones take seconds"));
  EXPECT_THAT(first.output, HasSubstr(" s left"));
  const support::Folder built;
  std::filesystem::create_directories(built / "build/release");
  std::ofstream(built / "build/release/build.ninja") << "\n";
  const auto later = on_a_fresh_machine(slow + "root=" + built.path() + "; expect_minutes; time_left; echo nothing");
  EXPECT_EQ(later.errors + later.output, "nothing\n");
}

TEST(Scripts, ABuildOnATerminalShowsItsStepsAndTheTimeLeft) {
  const support::Folder folder;
  std::ofstream(folder / "build.log") << "[1/9] one\n[4/9] four\nsomething else [7/9]\n";
  support::Terminal terminal(
      {"bash", "-c",
       ". " RUBICON_SOURCE_DIR "/scripts/common.sh; expected=$(($(date +%s) + 400)); sleep 100 & there=$!; "
       "trap 'kill $there' INT; show_progress " +
           folder.path() + "/build.log '^\\[[0-9]+/[0-9]+\\]' $there; echo ended"},
      24, 80);
  EXPECT_TRUE(terminal.shows("4 of 9, about 7 min left")) << terminal.text();
  terminal.type("\x03");
  EXPECT_TRUE(terminal.shows("ended")) << terminal.text();
  EXPECT_THAT(terminal.text(), Not(HasSubstr("4 of 9"))) << "the line of the progress is erased";
}

/// What scripts/package would call its packages in a tree with this cmake/commit.txt, and without git.
std::string version_of_archive(const std::string& commit) {
  const auto tree = std::filesystem::temp_directory_path() / ("rubicon_archive_" + std::to_string(::getpid()));
  std::filesystem::create_directories(tree / "scripts");
  std::filesystem::create_directories(tree / "cmake");
  const std::filesystem::path source = RUBICON_SOURCE_DIR;
  for (const auto* file : {"scripts/package", "scripts/common.sh", "CMakeLists.txt"})
    std::filesystem::copy_file(source / file, tree / file);
  std::ofstream(tree / "cmake/commit.txt") << commit << "\n";
  const auto outcome = support::run_to_end({"bash", (tree / "scripts/package").string(), "--version"});
  std::filesystem::remove_all(tree);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  return outcome.output;
}

TEST(Scripts, PackagesOfAnArchiveHaveTheVersionOfItsCommit) {
  const std::string commit = "700658ab12345678901234567890123456789012 1795471195 ";
  EXPECT_EQ(version_of_archive(commit), RUBICON_VERSION "~git20261123.215955.700658ab\n");
  EXPECT_EQ(version_of_archive(commit + "v0.0.9-7-g700658ab"), RUBICON_VERSION "~git20261123.215955.700658ab\n");
  EXPECT_EQ(version_of_archive(commit + "v" RUBICON_VERSION), RUBICON_VERSION "\n");
  EXPECT_EQ(version_of_archive("$Format:%H %ct$"), RUBICON_VERSION "\n") << "neither git nor an archive of it";
}

/// The number that the package would give the group may be that of another group of the host.
TEST(Scripts, TheContainerHasTheGroupOfPeopleWithItsNumberOnTheHostOrOneOfNoGroup) {
  std::ifstream file(RUBICON_SOURCE_DIR "/packaging/container/Containerfile");
  const std::string recipe{std::istreambuf_iterator<char>(file), {}};
  const auto number = recipe.find("ARG group=65533\n");
  const auto made = recipe.find("RUN groupadd --system --gid \"$group\" rubicon");
  const auto installed = recipe.find("apt-get install");
  ASSERT_NE(made, recipe.npos);
  EXPECT_LT(number, made);
  EXPECT_LT(made, installed) << "before others can get its number";
  for (const auto* line :
       {"\nUSER rubicon:rubicon\n", "\nHEALTHCHECK ", "\nVOLUME [\"/etc/rubicon\", \"/run/rubicon\""})
    EXPECT_NE(recipe.find(line), recipe.npos) << line;
}

/// As the container does: an ordinary user, a root that nobody can write, two volumes.
TEST(Scripts, TheContainerStartsAsAnOrdinaryUserOnAReadOnlyRoot) {
  const support::Folder volumes;
  for (const auto* one : {"state", "configuration", "meeting"}) std::filesystem::create_directories(volumes / one);
  std::ofstream(volumes / "configuration/home.yaml")
      << "island: {id: 7, name: home}\nnetworks: {dummy-1: {type: dummy}}\n";
  const std::string bin = RUBICON_BINARY_DIR "/bin", start = RUBICON_SOURCE_DIR "/packaging/container/start";
  const auto script =
      "set -e; mount --make-rprivate /; mount -t tmpfs none /mnt; mkdir /mnt/v; mount --bind " + volumes.path() +
      " /mnt/v; chown -R 65001:65001 /mnt/v/.; chmod 700 /mnt/v/meeting; mount -o remount,bind,ro /; cd /; "
      "export PATH=" +
      bin +
      ":$PATH RUBICON_STATE=/mnt/v/state RUBICON_CONFIGURATION=/mnt/v/configuration "
      "RUBICON_FOLDER=/mnt/v/meeting; user='setpriv --reuid=65001 --regid=65001 --clear-groups'; "
      "$user " +
      start +
      " home & for i in $(seq 200); do $user rubicon islands >/dev/null 2>&1 && break; sleep 0.1; done; "
      "$user rubicon islands; $user touch /x 2>&1 || true; stat -c '%a %u' /mnt/v/state/home; kill $!; wait $!";
  const auto outcome = support::run_to_end({"unshare", "--mount", "bash", "-c", script});
  if (outcome.errors.find("unshare failed") != std::string::npos || ::geteuid() != 0) GTEST_SKIP() << "needs root";
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("home"), std::string::npos) << outcome.output << outcome.errors;
  EXPECT_NE(outcome.output.find("700 65001"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("Read-only file system"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace rubicon::install
