#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {
namespace {

using testing::StartsWith;

const std::string kCases = RUBICON_SOURCE_DIR "/tests/cases/config";
const std::string kSaid = "# said: ", kWarning = "warning: ";

std::vector<std::string> mistakes() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(kCases)) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

/// The beginnings of the lines that the file itself expects: `3:20: networks.knx: unknown key ...`, or `warning: ` and
/// that.
std::vector<std::string> expected_of(const std::string& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(kSaid)) continue;
    line.erase(0, kSaid.size());
    const bool is_warning = line.starts_with(kWarning);
    lines.push_back((is_warning ? kWarning : "") + file + ":" + line.substr(is_warning ? kWarning.size() : 0));
  }
  return lines;
}

/// Those that `check` writes about the file.
std::vector<std::string> said_of(const std::string& file, const std::string& errors) {
  std::vector<std::string> lines;
  std::istringstream in(errors);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(file + ":") || line.starts_with(kWarning + file + ":")) lines.push_back(line);
  }
  return lines;
}

class Mistakes : public testing::TestWithParam<std::string> {};

TEST_P(Mistakes, AreNamedWithTheirPlaceAndWhatIsExpected) {
  const auto& file = GetParam();
  const auto checked = support::run_to_end({support::kDaemon, "check", file});
  const auto expected = expected_of(file);
  ASSERT_FALSE(expected.empty()) << "the file says what is expected";
  const auto said = said_of(file, checked.errors);
  ASSERT_EQ(said.size(), expected.size()) << checked.errors;
  for (std::size_t i = 0; i < said.size(); ++i) EXPECT_THAT(said[i], StartsWith(expected[i]));
  EXPECT_EQ(checked.code, expected[0].starts_with(kWarning) ? 0 : 2) << checked.errors;
}

INSTANTIATE_TEST_SUITE_P(OfConfigurations, Mistakes, testing::ValuesIn(mistakes()), [](const auto& one) {
  auto name = std::filesystem::path(one.param).stem().string();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-'; }, '_');
  return name;
});

}  // namespace
}  // namespace rubicon::daemon
