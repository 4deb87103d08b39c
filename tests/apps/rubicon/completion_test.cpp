#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/live_island.h"
#include "support/process.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;

/// The folder of a realm with two members.
class CompletionOfMembers : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(rubicon({"trust", "init", "--broker", "b.test", "--realm", realm_}).code, 0);
    for (const std::string name : {"hall", "lab"}) {
      ASSERT_EQ(rubicon({"trust", "add", name, "--realm", realm_, "--out", folder_.file(name + ".trust"),
                         "--phrase-file", folder_.file(name + ".phrase")})
                    .code,
                0);
    }
  }
  std::string offered(std::vector<std::string> words) const {
    words.insert(words.begin(), {"env", "RUBICON_REALM=" + realm_, kProgram, "complete", "--", "trust"});
    return support::run_to_end(words).output;
  }
  std::string in_bash(const std::string& line) const {
    return support::run_to_end({"env", "RUBICON_REALM=" + realm_, "bash", "-c",
                                "PATH=" RUBICON_BINARY_DIR "/bin:$PATH; . <(rubicon completion bash); COMP_LINE='" +
                                    line + "'; COMP_POINT=${#COMP_LINE}; compopt() { echo \"compopt $*\"; }; " +
                                    "_rubicon; echo \"${#COMPREPLY[@]}: ${COMPREPLY[*]}\""})
        .output;
  }

  Folder folder_;
  const std::string realm_ = folder_.file("realm");
};

TEST_F(CompletionOfMembers, OffersThemWhereOneIsNamed) {
  for (const auto* command : {"revoke", "renew", "change", "may"})
    EXPECT_EQ(offered({command, ""}), "hall\nlab\n") << command;
  EXPECT_EQ(offered({"revoke", "ha"}), "hall\n");
}

TEST_F(CompletionOfMembers, WhereANameIsNewNeitherAMemberNorAFileIsOffered) {
  EXPECT_EQ(offered({"add", ""}), "!\n");
  EXPECT_EQ(offered({"revoke", "desk"}), "!\n");
  EXPECT_EQ(offered({"join", ""}), "");
  EXPECT_EQ(offered({"may", "desk", "x"}), "!\n");
}

TEST_F(CompletionOfMembers, InBashNoFilesAreOfferedForAName) {
  EXPECT_EQ(in_bash("rubicon trust revoke ha"), "1: hall\n");
  EXPECT_EQ(in_bash("rubicon trust revoke desk"), "compopt +o bashdefault +o default\n0: \n");
  EXPECT_EQ(in_bash("rubicon trust join "), "0: \n");
}

TEST(Manual, ExamplesEndInALineOfTheirOwn) {
  const auto manual = rubicon({"manual"}).output;
  EXPECT_THAT(manual, HasSubstr("docs/trust.md.\n.EE\n"));
  for (auto at = manual.find(".EE"); at != manual.npos; at = manual.find(".EE", at + 1)) {
    EXPECT_EQ(manual[at - 1], '\n') << manual.substr(at - 80, 80);
  }
}

TEST(Manual, NamesTheVariablesOfAllOptionsAndTheFiles) {
  const auto manual = rubicon({"manual"}).output;
  for (const auto* name :
       {"RUBICON_ENGINE", "RUBICON_DOMAIN", "RUBICON_JSON", "RUBICON_PEIS_NETWORK", "RUBICON_PEIS_LISTEN",
        "RUBICON_PEIS_CONNECT", "RUBICON_PEIS_MULTICAST", "NO_COLOR", "RUBICON_KNX_PASSWORD"})
    EXPECT_THAT(manual, HasSubstr(name));
  EXPECT_THAT(manual, HasSubstr("\n.SH FILES\n"));
  EXPECT_THAT(manual, HasSubstr("\n.I /etc/rubicon/realm/\n"));
}

}  // namespace
}  // namespace rubicon::cli
