#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

#include "structure/tree.h"

namespace rubicon::structure {
namespace {

namespace fs = std::filesystem;

/// What is written once: the text that its copies have, and the files that may have it. All others use these.
struct Home {
  const char* what;
  std::vector<std::string> marks;
  std::set<std::string> files;
};

const std::vector<Home> kHomes{
    {"numbers in text: base::parse_number",
     {"from_chars("},
     // the last two parse numbers that other text follows
     {"src/base/text.h", "src/networks/knx/wire/blocks.cpp", "src/networks/knx/groups/esf_list.cpp"}},
    {"text without its blanks: base::trimmed", {"string_view trimmed(", "string trimmed("}, {"src/base/text.h"}},
    {"UTF-8: base::is_utf8", {"bool is_utf8("}, {"src/base/text.h", "src/base/text.cpp"}},
    {"characters in UTF-8: base::append_utf8, take_utf8",
     {"(0xc0 |", "(0xe0 |", "append_utf8(char32_t"},
     {"src/base/text.h", "src/base/text.cpp"}},
    {"text of outsiders: base::printable, one_line",
     {"string printable(", "string one_line("},
     {"src/base/text.h", "src/base/text.cpp"}},
    {"work that ends with its owner: base::Lifetime",
     {"shared_ptr<bool>", "weak_ptr<bool>", "shared_ptr<const bool>"},
     {"src/base/scheduler.h"}},
    {"network interfaces: transport/interfaces.h", {"getifaddrs("}, {"src/transport/interfaces.cpp"}},
    {"names of hosts: transport/host_names.h", {"getaddrinfo("}, {"src/transport/host_names.cpp"}},
    {"UDP ports of a DDS domain: tuples/dds/dds_options.h", {"7400", "7410"}, {"src/tuples/dds/dds_options.h"}},
};

std::string without_comments(const std::string& text) {
  std::string code;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) code += line.substr(0, line.find("//")) + '\n';
  return code;
}

bool has_mark(const Home& home, const std::string& code) {
  return std::ranges::any_of(home.marks, [&](const auto& mark) { return code.find(mark) != code.npos; });
}

TEST(OneHome, EachMechanismIsWrittenOnce) {
  for (const auto& file : product_sources()) {
    const auto code = without_comments(file.text);
    for (const auto& home : kHomes) {
      EXPECT_TRUE(home.files.contains(file.path) || !has_mark(home, code))
          << file.path << " has a copy of " << home.what;
    }
  }
}

TEST(OneHome, TheFilesOfTheListAreWhereTheMechanismsAre) {
  for (const auto& home : kHomes) {
    for (const auto& path : home.files)
      EXPECT_TRUE(has_mark(home, without_comments(read_text(root_folder() / path)))) << path << ": " << home.what;
  }
}

/// `src/networks/knx/line/tunnel.h` -> `rubicon::networks::knx::line`. The twins in memory/ stay with what they stand
/// for.
std::string namespace_of(const std::string& path) {
  std::string name = "rubicon";
  std::string folder = fs::path(path).parent_path().string().substr(4);
  if (folder.ends_with("/memory")) folder.resize(folder.size() - 7);
  for (const auto& part : fs::path(folder)) name += "::" + part.string();
  return name;
}

bool opens_its_namespace(const SourceFile& file) {
  static const std::regex kOpened(R"re((?:^|\n)namespace (rubicon::[\w:]+) \{)re");
  const auto expected = namespace_of(file.path);
  bool its_own = false;
  for (std::sregex_iterator it(file.text.begin(), file.text.end(), kOpened), end; it != end; ++it) {
    const auto name = (*it)[1].str();
    its_own = its_own || name == expected || name.starts_with(expected + "::");
  }
  return its_own;
}

TEST(Namespaces, FollowTheFolders) {
  for (const auto& file : files_below("src", {".h", ".cpp"})) {
    EXPECT_TRUE(opens_its_namespace(file)) << file.path << " does not open " << namespace_of(file.path);
  }
}

TEST(Namespaces, OneThatDoesNotFollowIsFound) {
  EXPECT_FALSE(opens_its_namespace({"src/networks/knx/line/x.h", "namespace rubicon::networks::knx {\n"}));
  EXPECT_TRUE(opens_its_namespace({"src/networks/knx/line/x.h", "namespace rubicon::networks::knx::line {\n"}));
  EXPECT_TRUE(opens_its_namespace({"src/tuples/memory/x.h", "#pragma once\nnamespace rubicon::tuples {\n"}));
}

TEST(Tests, MirrorTheFoldersOfWhatTheyTest) {
  // What tests several rooms at once, or the tree itself.
  const std::set<std::string> across{"cases",       "contract",  "ecology",    "examples",  "fuzz",   "install",
                                     "new_network", "scenarios", "simulators", "structure", "support"};
  for (const auto& entry : fs::recursive_directory_iterator(root_folder() / "tests")) {
    if (!entry.is_directory()) continue;
    const auto folder = fs::relative(entry.path(), root_folder() / "tests");
    if (across.contains(folder.begin()->string())) continue;
    const auto root = root_folder();
    const std::set<fs::path> special{"apps",
                                     "motes/allocation",
                                     "networks/knx/interop",
                                     "networks/knx/project/memory",
                                     "bridges/ros2/robot",
                                     "bridges/ros2/fast_robot"};
    EXPECT_TRUE(special.contains(folder) || fs::is_directory(root / "src" / folder) || fs::is_directory(root / folder))
        << "tests/" << folder.string() << " mirrors no folder of src/ or apps/";
  }
}

}  // namespace
}  // namespace rubicon::structure
