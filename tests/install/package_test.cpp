#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "install/installed.h"

namespace rubicon::install {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kCompiler = RUBICON_CXX " " RUBICON_SANITIZER_FLAGS " -std=c++20 -Wall -Wextra -Werror ";

class Package : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(all_.outcome().code, 0) << all_.outcome().output << all_.outcome().errors; }

  const Installed& all_ = Installed::get();
};

TEST_F(Package, EverythingHasItsPlace) {
  std::vector<std::string> wanted{"bin/rubicon-proxy",
                                  "lib/librubicon.so",
                                  "lib/librubicon.so.1",
                                  "lib/librubicon.so." RUBICON_VERSION,
                                  "lib/cmake/rubicon/rubiconConfig.cmake",
                                  "lib/cmake/rubicon/rubiconConfigVersion.cmake",
                                  "lib/cmake/rubicon/rubiconTargets.cmake",
                                  "lib/pkgconfig/rubicon.pc",
                                  "lib/systemd/system/rubicon-proxy@.service",
                                  "lib/systemd/system/rubicon-broker@.service",
                                  "include/rubicon/client.hpp",
                                  "share/doc/rubicon/LICENSE",
                                  "share/doc/rubicon/docs/service.md",
                                  "share/doc/rubicon/examples/home.yaml.example",
                                  "share/doc/rubicon/examples/loopback-only.conf",
                                  "share/doc/rubicon/examples/any-address.conf",
                                  "share/doc/rubicon/examples/client/3_own_loop/CMakeLists.txt",
                                  "share/man/man1/rubicon-proxy.1",
                                  "share/bash-completion/completions/rubicon-proxy"};
  if (RUBICON_HAS_COMMAND_LINE)
    wanted.insert(wanted.end(), {"bin/rubicon", "share/man/man1/rubicon.1", "share/bash-completion/completions/rubicon",
                                 "share/zsh/site-functions/_rubicon"});
  for (const auto& file : wanted) EXPECT_TRUE(fs::exists(all_.prefix() / file)) << file;
}

TEST_F(Package, TheLibraryNamesItselfByItsInterfaceVersion) {
  const auto dynamic = all_.shell("objdump -p " + (all_.prefix() / "lib/librubicon.so").string()).output;
  EXPECT_TRUE(std::regex_search(dynamic, std::regex(R"re(SONAME +librubicon\.so\.1\n)re"))) << dynamic;
  EXPECT_EQ(fs::read_symlink(all_.prefix() / "lib/librubicon.so.1"), "librubicon.so." RUBICON_VERSION);
}

/// What include/rubicon declares, as far as it can be told from the text. A header is about one namespace.
class Declared {
 public:
  explicit Declared(const fs::path& folder) {
    static const std::regex kSpace(R"re(namespace rubicon::(\w+) \{)re");
    for (const auto& file : fs::directory_iterator(folder)) {
      const auto text = read_text(file.path());
      for (std::sregex_iterator it(text.begin(), text.end(), kSpace), end; it != end; ++it) add((*it)[1], text);
    }
    types_.insert({"tuples::Link", "base::Scheduler"});  // named only
  }

  /// A symbol as nm -C spells it: `rubicon::client::Client::poll()`.
  bool has(const std::string& symbol) const {
    static const std::regex kForm(
        R"re(rubicon::(base|model|tuples|client)::(?:(\w+)::)?(~?\w+|operator=)(?:\[abi:cxx11\])?\((.*)\)(?: const)?)re");
    std::smatch parts;
    if (!std::regex_match(symbol, parts, kForm)) return false;
    const auto text = texts_.find(parts[1]);
    if (text == texts_.end() || (parts[2].matched && !types_.contains(parts[1].str() + "::" + parts[2].str())))
      return false;
    return text->second.find(parts[3].str() + "(") != std::string::npos && knows_types_of(parts[4]);
  }

 private:
  void add(const std::string& space, const std::string& text) {
    static const std::regex kType(R"re((?:class|struct|enum class) (?:\[\[nodiscard\]\] )?(\w+)[^;{]*\{)re");
    texts_[space] += text;
    for (std::sregex_iterator it(text.begin(), text.end(), kType), end; it != end; ++it)
      types_.insert(space + "::" + (*it)[1].str());
  }
  bool knows_types_of(const std::string& arguments) const {
    static const std::regex kOurs(R"re(rubicon::(\w+(?:::\w+)*))re");
    for (std::sregex_iterator it(arguments.begin(), arguments.end(), kOurs), end; it != end; ++it) {
      if (!types_.contains((*it)[1])) return false;
    }
    return true;
  }

  std::map<std::string, std::string> texts_;
  std::set<std::string> types_;
};

/// The names behind one of these letters of nm.
std::set<std::string> symbols(const std::string& listing, const std::string& letters) {
  std::set<std::string> names;
  std::istringstream lines(listing);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() < 20 || letters.find(line[17]) == letters.npos) continue;
    names.insert(line.substr(19, line.find("@@") - 19));
  }
  return names;
}

TEST_F(Package, TheLibraryShowsWhatTheHeadersDeclareAndNothingElse) {
  const Declared declared(all_.prefix() / "include/rubicon");
  const auto library = (all_.prefix() / "lib/librubicon.so").string();
  const auto shown = symbols(all_.shell("nm -DC --defined-only " + library).output, "TWVBDRui");
  EXPECT_GT(shown.size(), 50U);
  for (const auto& name : shown) EXPECT_TRUE(declared.has(name)) << "shown, but no header declares it: " << name;
  std::size_t found = 0;
  for (const auto* part : {"block_ground", "block_space", "block_member", "base", "model", "tuples", "client"}) {
    const auto archive = std::string(RUBICON_BINARY_DIR "/src/librubicon_") + part + ".a";
    for (const auto& name : symbols(all_.shell("nm -C --defined-only " + archive).output, "T")) {
      if (!declared.has(name)) continue;
      ++found;
      EXPECT_TRUE(shown.contains(name)) << "a header declares it, but packaging/library/rubicon.map hides it: " << name;
    }
  }
  EXPECT_GT(found, 50U);
}

TEST_F(Package, EveryHeaderStandsAlone) {
  std::size_t headers = 0;
  for (const auto& file : fs::directory_iterator(all_.prefix() / "include/rubicon")) {
    ++headers;
    const auto compiled = all_.shell("echo '#include <rubicon/" + file.path().filename().string() + ">' | " +
                                     kCompiler + "-Wpedantic -Wshadow -Wconversion -fsyntax-only -x c++ - -I " +
                                     (all_.prefix() / "include").string());
    EXPECT_EQ(compiled.code, 0) << compiled.output;
  }
  EXPECT_GE(headers, 8U);
}

TEST_F(Package, PkgConfigIsEnoughToBuildAnExample) {
  const auto source = (all_.prefix() / "share/doc/rubicon/examples/client/2_command.cpp").string();
  const auto program = (all_.workshop() / "command").string();
  const auto built =
      all_.shell(kCompiler + source + " $(pkg-config --cflags --libs rubicon) -o " + program + " && " + program);
  EXPECT_EQ(built.code, 2) << built.output;
  EXPECT_THAT(built.output, HasSubstr("usage: 2_command TYPE VALUE"));
}

TEST_F(Package, AProgramFindsTheLibraryOfAnUnusualPrefixByItsRunPath) {
  const auto source = (all_.prefix() / "share/doc/rubicon/examples/client/2_command.cpp").string();
  const auto program = (all_.workshop() / "with_path").string();
  const auto path = std::string("-Wl,-rpath,$(pkg-config --variable=libdir rubicon)");
  const auto built = all_.shell(kCompiler + source + " $(pkg-config --cflags --libs rubicon) " + path + " -o " +
                                program + " && env -u LD_LIBRARY_PATH " + program);
  EXPECT_THAT(built.output, HasSubstr("usage: 2_command TYPE VALUE"));
  for (const auto* page : {"service.md", "client.md"})
    EXPECT_THAT(read_text(all_.prefix() / "share/doc/rubicon/docs" / page), HasSubstr(path)) << page;
}

TEST_F(Package, ThePageNamesThePackagesOfAllLibrariesThatTheProgramsLoad) {
  if (all_.shell("command -v readelf && command -v dpkg").code != 0) GTEST_SKIP() << "no readelf or no dpkg here";
  const auto packages =
      all_.shell("readelf -d " + (all_.prefix() / "bin").string() +
                 "/* | sed -n 's/.*NEEDED.*\\[\\(.*\\)\\]/\\1/p' | sort -u | while read name; do "
                 "dpkg -S \"*/$(uname -m)-linux-gnu/$name\"; done 2>/dev/null | cut -d: -f1 | sort -u");
  ASSERT_THAT(packages.output, HasSubstr("libzip4"));
  const auto page = read_text(all_.prefix() / "share/doc/rubicon/docs/service.md");
  std::istringstream names(packages.output);
  const std::set<std::string> everywhere{"libc6", "libgcc-s1", "libstdc++6"};
  for (std::string name; std::getline(names, name);)
    EXPECT_TRUE(everywhere.contains(name) || page.find("`" + name + "`") != page.npos) << name;
}

TEST_F(Package, WhatThePageBuildsIsAllThatInstallingNeeds) {
  EXPECT_THAT(read_text(RUBICON_SOURCE_DIR "/docs/service.md"),
              HasSubstr("cmake --preset install && cmake --build build/install --target installable\n"));
  const auto made = all_.shell("ninja -C " RUBICON_BINARY_DIR " -t commands installable");
  ASSERT_EQ(made.code, 0) << made.output.substr(0, 500);
  // Of the files that are installed, those which the build makes; the others stand in the source or are configured.
  static const std::regex kFile("\"" RUBICON_BINARY_DIR "/((?:bin|lib|packaging/written)/[^\"]+)\"");
  const auto script = read_text(RUBICON_BINARY_DIR "/packaging/cmake_install.cmake");
  std::set<std::string> files;
  for (std::sregex_iterator it(script.begin(), script.end(), kFile), end; it != end; ++it) files.insert((*it)[1]);
  EXPECT_GE(files.size(), RUBICON_HAS_COMMAND_LINE ? 6U : 2U);
  for (const auto& file : files) {
    if (fs::is_symlink(RUBICON_BINARY_DIR "/" + file)) continue;
    const bool is_made =
        made.output.find(file + " ") != made.output.npos || made.output.find(file + "\n") != made.output.npos;
    EXPECT_TRUE(is_made) << file;
  }
}

TEST_F(Package, WhatWasInstalledIsTakenAwayAgainByItsList) {
  const auto prefix = all_.workshop() / "again";
  const auto page = read_text(all_.prefix() / "share/doc/rubicon/docs/service.md");
  EXPECT_THAT(page, HasSubstr("xargs -d '\\n' rm -f <build/install/install_manifest.txt"));
  const auto gone =
      all_.shell(RUBICON_CMAKE " --install " RUBICON_BINARY_DIR " --prefix " + prefix.string() + " >/dev/null; find " +
                 prefix.string() + " -type f | wc -l; xargs -d '\\n' rm -f <" +
                 RUBICON_BINARY_DIR "/install_manifest.txt; find " + prefix.string() + " -type f -o -type l | wc -l");
  EXPECT_EQ(gone.code, 0) << gone.output;
  EXPECT_TRUE(std::regex_match(gone.output, std::regex("[1-9][0-9]+\n0\n"))) << gone.output;
}

TEST_F(Package, NothingOfTheBuildTreeIsNeeded) {
  // In a mount namespace of its own the whole source tree, builds included, is empty.
  const std::string hidden = "unshare -m sh -ec 'mount -t tmpfs none " RUBICON_SOURCE_DIR "; ";
  if (all_.shell(hidden + "true'").code != 0) GTEST_SKIP() << "the source tree cannot be hidden here: no rights";
  const auto sample = (all_.prefix() / "share/doc/rubicon/examples/home.yaml.example").string();
  const auto ran = all_.shell(hidden + "ls " RUBICON_SOURCE_DIR "; " + all_.daemon() + " --version; " + all_.daemon() +
                              " check --elsewhere " + sample + "'");
  EXPECT_EQ(ran.code, 0) << ran.output;
  EXPECT_TRUE(ran.output.starts_with("rubicon-proxy " RUBICON_VERSION "\ncommit: ")) << ran.output;
  EXPECT_THAT(ran.output, HasSubstr("ok: 1 network ("));
}

/// The page without its indented and fenced code, where `](` is C++.
std::string without_code(const std::string& page) {
  std::istringstream lines(page);
  std::string text;
  bool fenced = false;
  for (std::string line; std::getline(lines, line);) {
    const bool fence = line.starts_with("```");
    fenced = fenced != fence;
    if (!fence && !fenced && !line.starts_with("    ")) text += line + "\n";
  }
  return text;
}

/// A function for each indented block of C++ of a page, below what they include.
std::string program_of(const std::string& page) {
  static const std::regex kBlock(R"re((?:\n(?: {4}[^\n]*)?)+\n)re"), kStatement(R"re(;\s*(//[^\n]*)?\n)re");
  std::string includes = "#include <chrono>\n#include <iostream>\n#include <vector>\n#include <rubicon/unit.hpp>\n";
  std::string functions;
  std::size_t number = 0;
  for (std::sregex_iterator it(page.begin(), page.end(), kBlock), end; it != end; ++it) {
    const auto block = (*it)[0].str();
    if (block.find("rubicon::") == block.npos || !std::regex_search(block, kStatement)) continue;
    const bool opens = block.find("auto client =") != block.npos;
    functions += "int example" + std::to_string(++number) + (opens ? "() {" : "(rubicon::Client& client) {");
    std::istringstream lines(block);
    for (std::string line; std::getline(lines, line);)
      (line.starts_with("    #include") ? includes : functions) += line + "\n";
    functions += "return 0; }\n";
  }
  return includes + functions;
}

TEST_F(Package, TheCodeOfThePageForComponentsCompiles) {
  const auto page = read_text(all_.prefix() / "share/doc/rubicon/docs/client.md");
  const auto program = program_of(page);
  for (const auto* call : {"client.command(", "client.read(", "client.send(", "client.watch_points(", "Client::open("})
    EXPECT_THAT(program, HasSubstr(call));
  const auto source = (all_.workshop() / "page.cpp").string();
  write_text(source, program);
  const auto compiled = all_.shell(RUBICON_CXX " -std=c++20 -fsyntax-only " + source + " -I " +
                                   (all_.prefix() / "include").string() + " 2>&1");
  EXPECT_EQ(compiled.code, 0) << compiled.output;
}

/// Targets of the links of a page that lead to files, without what stands behind `#`.
std::vector<std::string> links_of(const std::string& page) {
  static const std::regex kLink(R"re(\]\(([^)#\s]+)[^)]*\))re");
  std::vector<std::string> targets;
  for (std::sregex_iterator it(page.begin(), page.end(), kLink), end; it != end; ++it) {
    if ((*it)[1].str().find("://") == std::string::npos) targets.push_back((*it)[1]);
  }
  return targets;
}

TEST_F(Package, EveryLinkOfAnInstalledPageLeadsSomewhere) {
  std::size_t pages = 0, links = 0;
  for (const auto& file : fs::recursive_directory_iterator(all_.prefix() / "share/doc/rubicon")) {
    if (file.path().extension() != ".md") continue;
    ++pages;
    for (const auto& target : links_of(without_code(read_text(file.path())))) {
      ++links;
      EXPECT_TRUE(fs::exists(file.path().parent_path() / target)) << file.path() << " links to " << target;
    }
  }
  EXPECT_GT(pages, 20U);
  EXPECT_GT(links, 60U);
}

TEST_F(Package, EveryInstalledExampleIsGood) {
  std::size_t examples = 0;
  for (const auto& file : fs::directory_iterator(all_.prefix() / "share/doc/rubicon/examples")) {
    if (file.path().extension() != ".yaml") continue;
    ++examples;
    const auto checked = all_.shell(all_.daemon() + " check --elsewhere " + file.path().string());
    EXPECT_EQ(checked.code, 0) << checked.output;
  }
  EXPECT_GE(examples, 5U);
}

TEST_F(Package, ManualPagesAreSound) {
  if (all_.shell("command -v groff").code != 0) GTEST_SKIP() << "there is no groff here";
  for (const auto& page : fs::directory_iterator(all_.prefix() / "share/man/man1")) {
    const auto formatted = all_.shell("groff -ww -man -Tutf8 " + page.path().string() + " 2>&1 >/dev/null");
    EXPECT_EQ(formatted.output, "") << page.path();
  }
}

TEST_F(Package, CompletionKnowsTheCommandsOfTheDaemon) {
  const auto script = (all_.prefix() / "share/bash-completion/completions/rubicon-proxy").string();
  const auto completed = all_.shell("bash -c '. " + script +
                                    "; COMP_WORDS=(rubicon-proxy r); COMP_CWORD=1; _rubicon_proxy; "
                                    "echo ${COMPREPLY[@]}'");
  EXPECT_EQ(completed.output, "run recording\n");
}

}  // namespace
}  // namespace rubicon::install
