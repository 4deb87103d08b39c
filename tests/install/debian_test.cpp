#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "install/installed.h"

namespace rubicon::install {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const fs::path kPackaging = RUBICON_SOURCE_DIR "/packaging";
const fs::path kDebian = kPackaging / "debian";

Outcome sh(const std::string& line) {
  return support::run_to_end({"sh", "-ec", "exec 2>&1; " + line});
}

/// The words of a --version: `OpenSSL 3.0.17` -> its version.
std::string library_version(const std::string& output, const std::string& library) {
  std::smatch found;
  return std::regex_search(output, found, std::regex("[ :,] " + library + " ([0-9][^,\n]*)")) ? found[1].str()
                                                                                              : std::string();
}

TEST(Version, NamesProgramCommitAndLoadedLibraries) {
  std::vector<std::string> programs{"rubicon-proxy"};
  if (RUBICON_HAS_COMMAND_LINE) programs.emplace_back("rubicon");
  for (const auto& program : programs) {
    const auto text = support::run_to_end({RUBICON_BINARY_DIR "/bin/" + program, "--version"}).output;
    EXPECT_TRUE(std::regex_match(
        text, std::regex(program + " " RUBICON_VERSION "\ncommit: (not known|[0-9a-zA-Z.~-]+)\nlibraries: .+\n")))
        << text;
    for (const auto* library :
         {"Boost", "Cyclone DDS", "OpenSSL", "SQLite", "fmt", "yaml-cpp", "zstd", "expat", "libzip"})
      EXPECT_NE(library_version(text, library), "") << library << " in " << text;
  }
}

TEST(Version, OfALibraryIsThatOfTheLoadedOne) {
  const auto text = support::run_to_end({RUBICON_BINARY_DIR "/bin/rubicon-proxy", "--version"}).output;
  const auto package = sh("dpkg-query -W -f='${Version}\\n' libsqlite3-0");
  if (package.code != 0) GTEST_SKIP() << "there is no dpkg here";
  EXPECT_EQ(package.output.rfind(library_version(text, "SQLite") + "-", 0), 0U) << package.output << "\n" << text;
}

TEST(Version, HasOneSource) {
  std::size_t pages = 0;
  for (const auto& file : fs::recursive_directory_iterator(kPackaging / "man")) {
    if (!file.is_regular_file()) continue;
    ++pages;
    EXPECT_THAT(read_text(file.path()), HasSubstr("\"Rubicon " RUBICON_VERSION "\"")) << file.path();
  }
  EXPECT_EQ(pages, 5U);
}

TEST(Debian, MaintainerScriptsAreShell) {
  for (const auto* script : {"postinst", "prerm", "postrm", "config"}) {
    const auto file = kDebian / (std::string("rubicon.") + script);
    EXPECT_EQ(sh("sh -n " + file.string()).output, "") << script;
    const auto text = read_text(file);
    EXPECT_TRUE(text.starts_with("#!/bin/sh\n")) << script;
    EXPECT_THAT(text, HasSubstr("\nset -e\n")) << script;
    if (script != std::string("config")) {
      EXPECT_THAT(text, HasSubstr("\n#DEBHELPER#\n")) << script;
    }
  }
}

TEST(Debian, InstallingMakesNoKeysAndEnablesNothing) {
  const auto text = read_text(kDebian / "rubicon.postinst");
  for (const auto* word : {"rubicon trust", "openssl", "systemctl enable", "systemctl start"})
    EXPECT_THAT(text, Not(HasSubstr(word)));
}

TEST(Debian, AnUpgradeFromCertificatesForDdsSaysWhatToChoose) {
  const auto news = read_text(kDebian / "rubicon.NEWS");
  EXPECT_TRUE(news.starts_with("rubicon (")) << news;
  for (const auto* words : {"does not take part by DDS", "realm (docs/sites.md)", "`tuples: {trust: no}`",
                            "RUBICON_TRUST", "rubicon-trust@.service", "trust-key"})
    EXPECT_THAT(news, HasSubstr(words));
  if (sh("command -v dpkg-parsechangelog").code == 0) {
    EXPECT_EQ(sh("dpkg-parsechangelog --all -SUrgency -l" + (kDebian / "rubicon.NEWS").string()).output, "high\n");
  }
  EXPECT_THAT(read_text(kDebian / "rubicon.postinst"), HasSubstr("choose: a broker with a realm"));
}

TEST(Debian, KeysStayUnlessTheUserAnswersYes) {
  const auto question = read_text(kDebian / "rubicon.templates");
  EXPECT_THAT(question, HasSubstr("Template: rubicon/purge-keys-and-state\nType: boolean\nDefault: false\n"));
}

TEST(Debian, TheBillOfMaterialsNamesPackagesOfLibraries) {
  if (sh("command -v dpkg-query objdump python3").code != 0)
    GTEST_SKIP() << "there is no dpkg, objdump or python3 here";
  const auto made = sh((kPackaging / "make_sbom").string() +
                       " rubicon 1.2 " RUBICON_BINARY_DIR
                       "/bin/rubicon-proxy | python3 -c 'import json, sys; d = json.load(sys.stdin); "
                       "print(d[\"spdxVersion\"], *sorted(p[\"name\"] for p in d[\"packages\"])); "
                       "print(sorted({r[\"relationshipType\"] for r in d[\"relationships\"]}))'");
  EXPECT_EQ(made.code, 0) << made.output;
  EXPECT_TRUE(made.output.starts_with("SPDX-2.3 ")) << made.output;
  for (const auto* package : {" libddsc0debian", " libssl3", " libsqlite3-0", " libboost1.81-dev", " rubicon"})
    EXPECT_THAT(made.output, HasSubstr(package));
  EXPECT_THAT(made.output, HasSubstr("['DESCRIBES', 'DYNAMIC_LINK', 'STATIC_LINK']"));
}

TEST(Debian, TheBillOfMaterialsOfTheNativePythonModuleNamesTheLibraryOfThisTree) {
  const auto built = sh("ls " RUBICON_BINARY_DIR "/python/rubicon/_native*.so");
  if (built.code != 0 || sh("command -v dpkg-query objdump").code != 0)
    GTEST_SKIP() << "there is no native module, dpkg or objdump here";
  const auto made = sh((kPackaging / "make_sbom").string() + " python3-rubicon-native 1.2 " + built.output);
  EXPECT_EQ(made.code, 0) << made.output;
  for (const auto* package : {R"("librubicon1", "versionInfo": "1.2")", R"("name": "pybind11-dev")"})
    EXPECT_THAT(made.output, HasSubstr(package));
  EXPECT_THAT(made.output, Not(HasSubstr("libcli11-dev")));
}

TEST(Debian, ScriptsOfThePackagesAreBash) {
  for (const auto* script : {"scripts/package", "scripts/check_packages", "packaging/make_sbom"})
    EXPECT_EQ(sh("bash -n " RUBICON_SOURCE_DIR "/" + std::string(script)).output, "") << script;
}

TEST(Debian, ManualPagesOfTheSimulatorsAreSound) {
  if (sh("command -v groff").code != 0) GTEST_SKIP() << "there is no groff here";
  for (const auto& page : fs::directory_iterator(kPackaging / "man/simulators"))
    EXPECT_EQ(sh("groff -ww -man -Tutf8 " + page.path().string() + " 2>&1 >/dev/null").output, "") << page.path();
}

}  // namespace
}  // namespace rubicon::install
