#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {

inline std::string text_in(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline std::string mode_of(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return "absent";
  std::ostringstream text;
  text << std::oct << (about.st_mode & 07777U);
  return text.str();
}

/// A host with the authority and one island, and the folder of a person on another one.
class TrustCommands : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    folder_.write("home.yaml", small_island(6541, "{engine: dds}"));
  }
  std::string trust() const { return folder_.file("trust"); }
  Outcome trust(std::vector<std::string> words, const std::string& input = {}) const {
    return with(trust(), std::move(words), input);
  }
  static Outcome with(const std::string& folder, std::vector<std::string> words, const std::string& input = {}) {
    words.insert(words.begin(), {"trust", "dds"});
    words.insert(words.end(), {"--trust", folder});
    return rubicon(std::move(words), input);
  }
  void init() const { ASSERT_EQ(trust({"init"}).code, 0); }
  /// A bundle of a new member, and its phrase.
  std::pair<std::string, std::string> added(const std::string& name) const {
    const auto file = folder_.file(name + ".trust"), phrase = folder_.file(name + ".phrase");
    const auto outcome = trust({"add", name, "--out", file, "--phrase-file", phrase});
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    auto text = text_in(phrase);
    EXPECT_EQ(outcome.output.find(text.substr(0, text.find('\n'))), std::string::npos) << "the phrase is shown";
    return {file, text.substr(0, text.find('\n'))};
  }
  nlohmann::json member(const std::string& name, const std::string& folder) const {
    const auto shown = lines_of(with(folder, {"show", "--json"}));
    if (shown.empty()) return {};
    for (const auto& one : shown.front()["members"]) {
      if (one["name"] == name) return one;
    }
    return {};
  }

  PrivateNetwork alone_;
  Folder folder_;
};

}  // namespace rubicon::cli
