#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "support/conversation.h"
#include "support/folder.h"
#include "support/meeting_folder.h"
#include "support/mosquitto.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::ecology {

/// Islands of two sites, and tools elsewhere, that have nothing in common but a broker: each has a folder of its own.
class SitesOfABroker : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    if (const auto missing = support::Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
  }
  const std::string& meeting_of(const std::string& host) {
    auto& meeting = meetings_[host];
    if (!meeting) meeting = std::make_unique<support::MeetingFolder>();
    return meeting->path();
  }
  /// A host has a folder where its programs meet, and a home.
  std::vector<std::string> at(const std::string& host, std::vector<std::string> words) {
    const auto& meeting = meeting_of(host);
    const auto home = folder_ / host;
    std::filesystem::create_directories(home);
    std::vector<std::string> all{"env", "RUBICON_FOLDER=" + meeting, "HOME=" + home, "RUBICON_TRUST=no",
                                 "RUBICON_PATIENCE=30s"};
    all.insert(all.end(), words.begin(), words.end());
    return all;
  }
  support::Outcome run(const std::string& host, std::vector<std::string> words) {
    words.insert(words.begin(), RUBICON_BINARY_DIR "/bin/rubicon");
    return support::run_to_end(at(host, std::move(words)));
  }
  std::unique_ptr<support::Process> island(int id, const std::string& mqtt, const std::string& more = "") {
    return island_on("site" + std::to_string(id), id, "mqtt: " + mqtt, more);
  }
  std::unique_ptr<support::Process> island_on(const std::string& host, int id, const std::string& tuples,
                                              const std::string& more) {
    const auto name = "site" + std::to_string(id);
    const auto file = folder_ / (name + ".yaml");
    std::ofstream(file) << "island: {id: " << id << ", name: " << name << "}\ntuples: {" << tuples << "}\n"
                        << "history: {file: " << name << ".history}\n"
                        << "networks:\n  dummy-1: {type: dummy, simulate: {hall: {sensors: {temperature-1: {wave: "
                           "sine, low: 10, high: 30, period: 5s}}, actuators: {switch-1: {}}}}}\n"
                        << more;
    auto one = std::make_unique<support::Process>(
        at(host, {support::kDaemon, "run", file, "--shell", "--log-level", "warning"}));
    one->write("stats\n");
    EXPECT_TRUE(one->line_with("\"ok\"")) << one->errors();
    return one;
  }
  /// Until the command ends well, and says what it should.
  testing::AssertionResult until(const std::string& host, const std::vector<std::string>& words,
                                 const std::string& said) {
    support::Outcome last;
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (std::chrono::steady_clock::now() < end) {
      last = run(host, words);
      if (last.code == 0 && last.output.find(said) != std::string::npos) return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << last.code << ": " << last.output << last.errors;
  }

  support::PrivateNetwork alone_;
  support::Folder folder_;
  std::map<std::string, std::unique_ptr<support::MeetingFolder>> meetings_;
};

}  // namespace rubicon::ecology
