#include "apps/rubicon/doctor/remedies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>

namespace rubicon::cli {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::filesystem::path kRoot = RUBICON_SOURCE_DIR;

/// The findings of model/findings.h, by the names of their constants.
std::map<std::string, std::string> declared() {
  std::map<std::string, std::string> all;
  const auto text = text_of(kRoot / "src/model/findings.h");
  const std::regex constant(R"re(string_view (k\w+) = "([a-z-]+)")re");
  for (std::sregex_iterator one(text.begin(), text.end(), constant), end; one != end; ++one) all[(*one)[1]] = (*one)[2];
  return all;
}

TEST(Remedies, ThereIsOneForEachFindingAndNoOther) {
  std::set<std::string> findings, known;
  for (const auto& [name, word] : declared()) findings.insert(word);
  for (const auto& one : remedies()) {
    EXPECT_TRUE(known.insert(std::string(one.finding)).second) << one.finding << " has two";
    EXPECT_FALSE(one.fix.empty()) << one.finding;
    EXPECT_TRUE(std::filesystem::exists(kRoot / "docs" / one.page.substr(0, one.page.find('#')))) << one.page;
  }
  EXPECT_GE(findings.size(), 30U);
  EXPECT_EQ(known, findings);
  EXPECT_EQ(remedy_of(""), nullptr);
}

TEST(Remedies, EachFindingIsGivenSomewhereAndDocumented) {
  std::string sources;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kRoot / "src")) {
    if (entry.path().extension() == ".cpp") sources += text_of(entry.path());
  }
  const auto page = text_of(kRoot / "docs/errors.md");
  for (const auto& [name, word] : declared()) {
    EXPECT_NE(sources.find("findings::" + name), sources.npos) << name << " is given by nobody";
    EXPECT_NE(page.find("`" + word + "`"), page.npos) << word << " is not in docs/errors.md";
  }
}

/// They compare words and numbers of their own, never parts of sentences.
TEST(Remedies, NoCheckSearchesSentences) {
  for (const auto& entry : std::filesystem::directory_iterator(kRoot / "apps/rubicon/doctor")) {
    const auto text = text_of(entry.path());
    for (const auto* searched : {"reason.find(", "what.find(", "why.find(", "what.contains(", "reason.contains("})
      EXPECT_EQ(text.find(searched), text.npos) << entry.path() << ": " << searched;
  }
}

}  // namespace
}  // namespace rubicon::cli
