#include "apps/rubicon/secure_findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Grade = Finding::Grade;

constexpr WallTime kToday{std::chrono::seconds(1'767'225'600)};

IslandSeen seen_with(const std::string& line, const std::string& reason) {
  IslandSeen seen;
  seen.island.id = OwnerId(6541);
  seen.known_before = true;
  client::Network one;
  one.id = "knx";
  one.line = {line, reason, kToday - 5min, 3, kToday + 60s};
  seen.before = seen.now = {one};
  return seen;
}

/// A reason that a line gives, and a word of the advice.
struct Refusal {
  const char* line;
  const char* reason;
  const char* advice;
};

class SecureRefusals : public testing::TestWithParam<Refusal> {};

TEST_P(SecureRefusals, AreProblemsWithARemedy) {
  const auto found = check_lines(seen_with(GetParam().line, GetParam().reason), kToday).at(0);
  EXPECT_EQ(found.grade, Grade::kProblem);
  EXPECT_THAT(found.what, HasSubstr(GetParam().reason));
  EXPECT_THAT(found.fix, AllOf(HasSubstr(GetParam().advice), HasSubstr("docs/knx-secure.md#line-states")));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, SecureRefusals,
    testing::Values(
        Refusal{"refused", "house.knxkeys: the password of the keyring is wrong",
                "`keyring-password-file`, and reload"},
        Refusal{"refused",
                "house.knxkeys: the password of the keyring is wrong, or the keyring was changed after ETS exported it",
                "if it is that one, export"},
        Refusal{"refused", "house.knxkeys: the keyring was changed after ETS exported it", "export the keyring"},
        Refusal{
            "refused",
            "the interface does not accept user 4 with this password: the user number or the user password is wrong "
            "(session status 1)",
            "export the keyring again"},
        Refusal{"refused",
                "the interface is not the device that the configuration names, or the device password (authentication "
                "code) is wrong: its proof of identity does not match",
                "`device-password-file`"},
        Refusal{"refused",
                "the interface does not offer this type of connection (does it require KNX IP Secure?) (status 22)",
                "`keyring`, `keyring-password-file` and `via: tunnel-tcp`"},
        Refusal{"refused", "house.knxkeys: it has no backbone key for secure routing", "`backbone-key-file`"},
        Refusal{"refused", "all secure sessions of the interface are in use (session 0)", "another client"},
        Refusal{"refused", "the interface does not authorise this user (status 28); user 4 has no tunnel there",
                "download the interface"},
        Refusal{"up", "there is no key for the secured group 1/2/7: nothing is sent to it or taken from it",
                "configure `keyring`"},
        Refusal{"up", "what the group sends has another backbone key: compare the keyring with the ETS project",
                "export the keyring again"}));

TEST(SecureRemedies, OtherReasonsHaveNone) {
  EXPECT_EQ(secure_remedy("connection refused"), "");
  EXPECT_EQ(secure_remedy(""), "");
  EXPECT_THAT(check_lines(seen_with("down", "connection refused"), kToday).at(0).fix, HasSubstr("check cable"));
}

/// All text of the KNX network.
std::string source_of_knx() {
  std::string all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(RUBICON_SOURCE_DIR "/src/networks/knx")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream file(entry.path());
    all.append(std::istreambuf_iterator<char>(file), {});
  }
  return all;
}

TEST(SecureRemedies, FitTheReasonsOfTheNetwork) {
  const auto source = source_of_knx();
  for (const auto part : secure_reasons()) EXPECT_NE(source.find(part), source.npos) << part;
  EXPECT_THAT(secure_reasons(), SizeIs(testing::Ge(10U)));
}

TEST(SecureCounters, ThatGrowAreProblemsWithTheirMeaning) {
  auto seen = seen_with("up", "");
  seen.before[0].properties = {{"data-secure-plain-dropped", "2"}, {"data-secure-old", "5"}};
  seen.now[0].properties = {{"data-secure-plain-dropped", "4"}, {"data-secure-old", "5"}, {"data-secure-sent", "9"}};
  const auto found = check_secure(seen);
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].check, "secure");
  EXPECT_EQ(found[0].grade, Grade::kProblem);
  EXPECT_EQ(found[0].what,
            "network knx of island 6541: dropped 4 (data-secure-plain-dropped) since its start, 2 of them during the "
            "check: plain telegrams to secured groups");
  EXPECT_THAT(found[0].fix, AllOf(HasSubstr("downloaded"), HasSubstr("docs/knx-secure.md#counters")));
  EXPECT_EQ(found[1].grade, Grade::kNote);
  EXPECT_THAT(found[1].what, HasSubstr("dropped 5 (data-secure-old) since its start, none during the check"));
  for (const auto& loss : check_losses(seen)) EXPECT_EQ(loss.grade, Grade::kGood) << loss.what << ": named once";
}

TEST(SecureCounters, WithoutAFirstObservationAreNotes) {
  auto seen = seen_with("up", "");
  seen.known_before = false;
  seen.now[0].properties = {{"secure-replays", "1"}};
  const auto found = check_secure(seen);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].grade, Grade::kNote);
}

TEST(SecureCounters, AnInterfaceThatIsNotVerifiedIsANote) {
  auto seen = seen_with("up", "");
  seen.now[0].properties = {{"secure-sessions", "1"}, {"secure-unverified", "1"}};
  const auto found = check_secure(seen);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].grade, Grade::kNote);
  EXPECT_THAT(found[0].fix, HasSubstr("`device-password-file`"));
}

TEST(SecureCounters, OfAQuietLineAreNotFindings) {
  auto seen = seen_with("up", "");
  seen.now[0].properties = {{"secure-sessions", "1"},      {"secure-replays", "0"},
                            {"data-secure-received", "7"}, {"data-secure-tool-access", "3"},
                            {"secure-own-frames", "12"},   {"secure-notifies-sent", "4"}};
  EXPECT_THAT(check_secure(seen), IsEmpty());
}

/// What a counter of the network means stands on the page that doctor names.
TEST(SecureCounters, AreAllOnTheirPage) {
  std::ifstream file(RUBICON_SOURCE_DIR "/docs/knx-secure.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const auto* name : {"data-secure-sent",
                           "data-secure-refused",
                           "data-secure-received",
                           "data-secure-plain-dropped",
                           "data-secure-no-key",
                           "data-secure-unknown-sender",
                           "data-secure-wrong-mac",
                           "data-secure-old",
                           "data-secure-tool-access",
                           "data-secure-synchronisation",
                           "data-secure-point-to-point",
                           "data-secure-other",
                           "secure-sessions",
                           "secure-unverified",
                           "secure-plain-frames",
                           "secure-early-frames",
                           "secure-wrong-mac",
                           "secure-replays",
                           "secure-other-sessions",
                           "secure-forbidden-frames",
                           "secure-sent",
                           "secure-received",
                           "secure-old",
                           "secure-early",
                           "secure-forbidden",
                           "secure-bad-frames",
                           "secure-own-frames",
                           "secure-notifies-sent",
                           "secure-notifies-received"})
    EXPECT_THAT(page, HasSubstr("`" + std::string(name) + "`"));
}

}  // namespace
}  // namespace rubicon::cli
