#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <regex>
#include <set>
#include <sstream>

#include "structure/tree.h"

namespace rubicon::structure {
namespace {

namespace fs = std::filesystem;

std::vector<SourceFile> all_sources() {
  std::vector<SourceFile> all;
  for (const auto* folder : {"src", "apps", "tests", "bench", "examples", "include", "python"}) {
    for (auto& file : files_below(folder, {".h", ".cpp", ".py", ".pyi"})) all.push_back(std::move(file));
  }
  for (auto& file : files_below("bench/python", {""})) all.push_back(std::move(file));
  return all;
}

TEST(HouseRules, NoSourceFileIsLongerThan500Lines) {
  for (const auto& file : all_sources()) {
    EXPECT_LE(std::count(file.text.begin(), file.text.end(), '\n'), 500) << file.path;
  }
}

/// One that reads a room opens few files, and each holds an idea.
TEST(HouseRules, FilesAreIdeasAndNotFunctions) {
  std::vector<std::ptrdiff_t> lines;
  for (const auto* folder : {"src", "apps"}) {
    for (const auto& file : files_below(folder, {".h", ".cpp"}))
      lines.push_back(std::count(file.text.begin(), file.text.end(), '\n'));
  }
  std::sort(lines.begin(), lines.end());
  ASSERT_GE(lines.size(), 500U);
  EXPECT_GE(lines[lines.size() / 2], 110) << "lines of the file in the middle";
  const auto all = std::accumulate(lines.begin(), lines.end(), std::ptrdiff_t{0});
  EXPECT_LE(static_cast<double>(lines.size()) * 1000 / static_cast<double>(all), 7.5) << "files for 1000 lines";
}

/// A bound is kMax or kMin of something, and no other word.
TEST(HouseRules, BoundsHaveOnePrefix) {
  static const std::regex kOther(R"re(\bk(?:Most|Longest|Largest|Highest|Shortest|Least|Lowest)(?:[A-Z]\w*)?\b)re");
  for (const auto& file : all_sources()) {
    std::smatch found;
    if (std::regex_search(file.text, found, kOther)) ADD_FAILURE() << file.path << " names " << found.str();
  }
}

/// The first line of a page that is longer than 140 characters; tables, commands and quotations have the lines that
/// they need.
std::string long_line_of(const std::string& page) {
  std::istringstream text(page);
  bool code = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("```")) code = !code;
    if (code || line.starts_with("    ") || line.starts_with("|") || line.starts_with(">")) continue;
    const auto characters = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xc0) != 0x80; });
    if (characters > 140) return line;
  }
  return {};
}

TEST(HouseRules, LinesOfDocumentsHaveAtMost140Characters) {
  std::vector<SourceFile> pages;
  for (const auto* folder : {"docs", "src", "apps", "tests", "bench", "python", "examples", "packaging"})
    for (auto& page : files_below(folder, {".md"})) pages.push_back(std::move(page));
  for (const auto* name : {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "web/README.md"})
    pages.push_back({name, read_text(root_folder() / name)});
  EXPECT_GE(pages.size(), 80U);
  for (const auto& page : pages) EXPECT_EQ(long_line_of(page.text), "") << page.path;
}

TEST(HouseRules, NoTypeIsCalledManagerHandlerHelperUtilBaseDataOrInfo) {
  static const std::regex kBad(
      R"re(\b(?:class|struct|enum class)\s+(\w*(?:Manager|Handler|Helper|Util|Utils|Base|Data|Info)|\w+Impl)\b[^;]*\{)re");
  for (const auto& file : all_sources()) {
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), kBad), end; it != end; ++it) {
      ADD_FAILURE() << file.path << " names a type " << (*it)[1];
    }
  }
}

/// Cyclone DDS changes them as it likes: what is not in dds.h is not ours. Packets are DDSI-RTPS, that is another word.
TEST(HouseRules, NothingNamesTheInternalsOfCycloneDds) {
  static const std::regex kInternal(
      R"re(\bddsi_[a-z]|\bq_[a-z_]+\.h|\b(?:dds|DDS)_[Ss]ecurity_|\bdds_rhc|\bnn_[a-z]+_t|<dds/(?:ddsi|security)/|<dds/ddsc/dds_rhc)re");
  auto all = all_sources();
  for (const auto* folder : {"src", "packaging", "scripts", "cmake", "tests", "bench"}) {
    for (auto& file : files_below(folder, {".c", ".map", ".cmake", ".txt", ".in", ".idl", ""}))
      all.push_back(std::move(file));
  }
  for (const auto& file : all) {
    std::smatch found;
    if (std::regex_search(file.text, found, kInternal) && file.path != "tests/structure/house_rules_test.cpp")
      ADD_FAILURE() << file.path << " names " << found.str();
  }
}

/// GCC takes a function that only fetches for one without effects, and leaves its calls out.
TEST(HouseRules, OnlyBasePrefetchFetchesAhead) {
  for (const auto& file : product_sources()) {
    const bool fetches = file.text.find("__builtin_prefetch") != std::string::npos;
    EXPECT_EQ(fetches, file.path == "src/base/prefetch.h") << file.path;
  }
}

/// A test that meets an island of the host, or of another test, fails for no reason of its own.
TEST(HouseRules, EachTestProgramMeetsOthersInAFolderOfItsOwn) {
  const auto* const folder = std::getenv("RUBICON_FOLDER");
  ASSERT_NE(folder, nullptr) << "of this program";
  EXPECT_TRUE(fs::is_directory(folder));
  std::ifstream file(RUBICON_SOURCE_DIR "/cmake/rubicon.cmake");
  const std::string rules{std::istreambuf_iterator<char>(file), {}};
  const auto made = rules.find("add_executable(${target} ${sources}", rules.find("function(rubicon_test "));
  ASSERT_NE(made, rules.npos);
  const auto line = rules.substr(made, rules.find('\n', made) - made);
  EXPECT_NE(line.find("/tests/support/every_program/own_folder.cpp)"), line.npos) << line;
}

TEST(HouseRules, NothingIsLeftToDoLaterAndNoMachineIsNamed) {
  // Spelled in two pieces, so that this file does not find itself.
  const std::vector<std::string> words{std::string("TO") + "DO", std::string("FIX") + "ME", std::string("/wo") + "rk/",
                                       std::string("DISABLED") + "_"};
  for (const auto& file : all_sources()) {
    for (const auto& word : words) EXPECT_EQ(file.text.find(word), std::string::npos) << file.path << ": " << word;
  }
}

/// ordered_json searches all members for each one that it adds: a text of many members takes seconds.
TEST(HouseRules, OnlyShortTextsAreParsedIntoOrderedJson) {
  const std::set<std::string> short_texts{"src/model/point.cpp",                    // at most kMaxInput bytes
                                          "src/networks/knx/dpt/meter_codec.cpp",   // at most kMaxJson
                                          "src/networks/knx/dpt/record_codec.cpp",  // the same
                                          "src/networks/knx/dpt/time_codec.cpp",    // the same
                                          "src/island/island_tuples.cpp",           // our own text
                                          "src/model/json_text.h",
                                          "src/model/json_text.cpp"};
  for (const auto& file : product_sources()) {
    const bool parses = file.text.find("parse_ordered_json(") != std::string::npos;
    EXPECT_EQ(parses, short_texts.contains(file.path)) << file.path;
  }
}

/// Each block that calls them compiles the parser and the serializer once more.
TEST(HouseRules, JsonIsParsedAndWrittenInOnePlace) {
  static const std::regex kCall(R"re(\b(?:json|Json|\w*Tree|Line)::(?:parse|accept)\(|(?:\.|->)dump\()re");
  for (const auto& file : product_sources()) {
    if (file.path == "src/model/json_text.cpp" || file.path.find("zigbee/bridge/") != std::string::npos)
      continue;  // simdjson
    std::smatch found;
    EXPECT_FALSE(std::regex_search(file.text, found, kCall))
        << file.path << ": " << found.str() << ", expected model/json_text.h";
  }
}

TEST(HouseRules, EveryNetworkFolderHasItsFourParts) {
  std::vector<fs::path> folders{root_folder() / "examples/network-template"};
  for (const auto& entry : fs::directory_iterator(root_folder() / "src/networks")) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  for (const auto& folder : folders) {
    auto name = folder.filename().string();
    if (name == "network-template") name = "template";
    for (const auto& part :
         {name + "_network.h", name + "_network.cpp", std::string("sample.yaml"), std::string("README.md")}) {
      EXPECT_TRUE(fs::exists(folder / part)) << folder.filename() << " has no " << part;
    }
  }
}

TEST(HouseRules, EveryFuzzTargetHasSeeds) {
  std::size_t targets = 0;
  for (const auto& file : files_below("tests/fuzz", {".cpp"})) {
    const auto stem = fs::path(file.path).stem().string();
    if (!stem.ends_with("_fuzz")) continue;
    ++targets;
    const auto seeds = root_folder() / "tests/fuzz/seeds" / stem.substr(0, stem.size() - 5);
    EXPECT_TRUE(fs::exists(seeds) && !fs::is_empty(seeds)) << stem << " has no seeds in " << seeds.filename();
  }
  EXPECT_GE(targets, 7U);
}

/// The promises of D1.4, and who can do what to a building.
TEST(HouseRules, TheTablesOfPromisesAndOfAttackersNameTestsThatExist) {
  std::set<std::string> tests;
  static const std::regex kTest(R"re(TEST(?:_P|_F)?\((\w+),\s*(\w+)\))re");
  for (const auto& file : files_below("tests", {".cpp"})) {
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), kTest), end; it != end; ++it) {
      tests.insert((*it)[1].str() + "." + (*it)[2].str());
    }
  }
  static const std::regex kNamed(R"re(`([A-Z]\w+\.[A-Z]\w+)`)re");
  for (const std::string page : {"docs/d1.4.md", "docs/trust.md"}) {
    const auto table = read_text(root_folder() / page);
    std::size_t named = 0;
    for (std::sregex_iterator it(table.begin(), table.end(), kNamed), end; it != end; ++it, ++named) {
      EXPECT_TRUE(tests.contains((*it)[1].str())) << page << " names " << (*it)[1] << ", no such test";
    }
    EXPECT_GE(named, 15U) << page;
  }
}

TEST(HouseRules, TheCoverageTableOfD14NamesBrowserTestsThatExist) {
  std::set<std::string> tests;
  static const std::regex kTest(R"re(name: "([a-z]+: [^"]+)")re");
  for (const auto& file : files_below("tests/web", {".mjs"})) {
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), kTest), end; it != end; ++it)
      tests.insert((*it)[1].str());
  }
  static const std::regex kNamed("`([a-z]+: [^`]+)`");
  const auto table = read_text(root_folder() / "docs/d1.4.md");
  std::size_t named = 0;
  for (std::sregex_iterator it(table.begin(), table.end(), kNamed), end; it != end; ++it, ++named) {
    EXPECT_TRUE(tests.contains((*it)[1].str())) << "docs/d1.4.md names " << (*it)[1] << ", no such test";
  }
  EXPECT_GE(named, 8U);
}

}  // namespace
}  // namespace rubicon::structure
