#include "apps/rubicon/doctor/secure_findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "model/findings.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Grade = Finding::Grade;

constexpr WallTime kToday{std::chrono::seconds(1'767'225'600)};

IslandSeen seen_with(const std::string& line, const std::string& reason, std::string_view finding = {}) {
  IslandSeen seen;
  seen.island.id = OwnerId(6541);
  seen.known_before = true;
  client::Network one;
  one.id = "knx";
  one.line = {line, reason, kToday - 5min, 3, kToday + 60s, std::string(finding)};
  seen.before = seen.now = {one};
  return seen;
}

TEST(SecureRefusals, AreProblemsWithTheRemedyOfTheirFinding) {
  using namespace model::findings;
  for (const auto* line : {"refused", "up"}) {
    const auto found = check_lines(seen_with(line, "house.knxkeys: a sentence", kKeyringPassword), kToday).at(0);
    EXPECT_EQ(found.grade, Grade::kProblem);
    EXPECT_THAT(found.what, HasSubstr("house.knxkeys: a sentence"));
    EXPECT_THAT(found.fix,
                AllOf(HasSubstr("`keyring-password-file`, and reload"), HasSubstr("docs/knx-secure.md#line-states")));
  }
  EXPECT_THAT(check_lines(seen_with("down", "the password of the keyring is wrong"), kToday).at(0).fix,
              HasSubstr("check cable"))
      << "sentences are for people";
  EXPECT_THAT(check_lines(seen_with("down", "", "of-a-newer-release"), kToday).at(0).fix, HasSubstr("check cable"));
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
