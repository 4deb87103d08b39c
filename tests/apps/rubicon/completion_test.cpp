#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/live_island.h"
#include "support/process.h"
#include "support/trust_realm.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;

/// A folder of trust with the people of the host and an island.
class CompletionOfMembers : public testing::Test {
 protected:
  std::string offered(std::vector<std::string> words) const {
    if (words.front() != "may") words.insert(words.begin(), "dds");
    words.insert(words.begin(), {"env", "RUBICON_TRUST=" + trust_, kProgram, "complete", "--", "trust"});
    return support::run_to_end(words).output;
  }
  std::string in_bash(const std::string& line) const {
    return support::run_to_end({"env", "RUBICON_TRUST=" + trust_, "bash", "-c",
                                "PATH=" RUBICON_BINARY_DIR "/bin:$PATH; . <(rubicon completion bash); COMP_LINE='" +
                                    line + "'; COMP_POINT=${#COMP_LINE}; compopt() { echo \"compopt $*\"; }; " +
                                    "_rubicon; echo \"${#COMPREPLY[@]}: ${COMPREPLY[*]}\""})
        .output;
  }

  Folder folder_;
  const std::string trust_ = folder_.file("trust");
  const support::TrustRealm realm_{trust_, {OwnerId{7}}};
};

TEST_F(CompletionOfMembers, OffersThemWhereOneIsNamed) {
  for (const auto* command : {"revoke", "renew", "export", "may"})
    EXPECT_EQ(offered({command, ""}), "island-7\nlocal\n") << command;
  EXPECT_EQ(offered({"revoke", "isl"}), "island-7\n");
}

TEST_F(CompletionOfMembers, WhereANameIsNewNeitherAMemberNorAFileIsOffered) {
  for (const auto* command : {"add", "request"}) EXPECT_EQ(offered({command, ""}), "!\n") << command;
  EXPECT_EQ(offered({"revoke", "desk"}), "!\n");
  EXPECT_EQ(offered({"join", ""}), "");
  EXPECT_EQ(offered({"may", "desk", "x"}), "!\n");
}

TEST_F(CompletionOfMembers, InBashNoFilesAreOfferedForAName) {
  EXPECT_EQ(in_bash("rubicon trust dds revoke isl"), "1: island-7\n");
  EXPECT_EQ(in_bash("rubicon trust dds revoke desk"), "compopt +o bashdefault +o default\n0: \n");
  EXPECT_EQ(in_bash("rubicon trust dds join "), "0: \n");
}

TEST(Manual, ExamplesEndInALineOfTheirOwn) {
  const auto manual = rubicon({"manual"}).output;
  EXPECT_THAT(manual, HasSubstr("See docs/trust.md.\n.EE\n"));
  for (auto at = manual.find(".EE"); at != manual.npos; at = manual.find(".EE", at + 1)) {
    EXPECT_EQ(manual[at - 1], '\n') << manual.substr(at - 80, 80);
  }
}

TEST(Manual, NamesTheVariablesOfAllOptionsAndTheFiles) {
  const auto manual = rubicon({"manual"}).output;
  for (const auto* name :
       {"RUBICON_ENGINE", "RUBICON_DOMAIN", "RUBICON_TRUST", "RUBICON_JSON", "RUBICON_PEIS_NETWORK",
        "RUBICON_PEIS_LISTEN", "RUBICON_PEIS_CONNECT", "RUBICON_PEIS_MULTICAST", "NO_COLOR", "RUBICON_KNX_PASSWORD"})
    EXPECT_THAT(manual, HasSubstr(name));
  EXPECT_THAT(manual, HasSubstr("\n.SH FILES\n"));
  EXPECT_THAT(manual, HasSubstr("\n.I /etc/rubicon/trust/\n"));
}

}  // namespace
}  // namespace rubicon::cli
