#include "apps/rubicon/trust_findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::cli {
namespace {

using testing::Contains;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using Grade = Finding::Grade;
using Own = Result<std::shared_ptr<rubicon::trust::Trust>>;

IslandSeen island_of_trust() {
  IslandSeen seen;
  seen.island.id = OwnerId(6541);
  seen.island.summary.name = "home";
  return seen;
}

TEST(TrustFindings, WhoHasNoTrustIsNotBlamed) {
  EXPECT_THAT(check_own_trust(Own(nullptr)), IsEmpty());
}

TEST(TrustFindings, EachRefusalHasARemedy) {
  const std::pair<const char*, const char*> cases[] = {
      {"/etc/rubicon/trust/members/local/key.pem: anna may not use the key of this host: run `sudo adduser anna "
       "rubicon` and log in again",
       "sudo adduser USER rubicon, then log in again"},
      {"members/local/key.pem: this host has no group rubicon: run `sudo addgroup --system rubicon`, ... `sudo adduser",
       "sudo addgroup --system rubicon"},
      {"members/local/key.pem: is for root only: run `sudo rubicon trust dds init`, which gives it to the group "
       "rubicon",
       "sudo rubicon trust dds init"},
      {"members/island-1/key.pem: systemd handed over no key (credential trust-key): ...", "journalctl"},
      {"members/panel/key.pem: is for root only: `rubicon trust dds join` takes a member of your own",
       "rubicon trust dds join FILE"},
      {"members/desk/key.pem: others may use this key: expected the mode 0600", "revoke its member"},
      {"members/desk/key.pem: a group may read this key: expected the mode 0600", "revoke its member"},
      {"members/desk/certificate.pem: CN=desk ended on 2026-01-01, and the clock says 2027-01-01",
       "rubicon trust dds renew"},
      {"members/desk/certificate.pem: CN=desk is not valid before 2026-01-01, and the clock says 1970-01-01", "clock"},
      {"members/desk/certificate.pem: CN=desk is of another realm than CN=x", "joined another realm"},
      {"desk was revoked", "another name"},
      {"/usr/lib/rubicon/librubicon-guard.so: cannot load the guard: no such file",
       "install the package rubicon again"},
      {"/usr/lib/rubicon/librubicon-guard.so: is of another version of Rubicon (guard 2, expected 1)",
       "sudo apt install rubicon librubicon1"},
      {"/x: has no realm, but islands of this host started with Rubicon 5f1c", "put the folder back from your copy"},
      {"/x: has no realm: expected a folder that `rubicon trust dds init` or `rubicon trust dds join` made",
       "rubicon trust dds init"},
      {"desk may not set proxy.a", "rubicon trust may"},
  };
  for (const auto& [reason, fix] : cases) {
    const auto found = check_own_trust(Own(fail(ErrorCode::kRefused, reason)));
    ASSERT_THAT(found, SizeIs(1));
    EXPECT_EQ(found[0].grade, Grade::kProblem);
    EXPECT_EQ(found[0].what, reason);
    EXPECT_THAT(found[0].fix, HasSubstr(fix)) << reason;
  }
  EXPECT_THAT(check_own_trust(Own(fail(ErrorCode::kIo, "no space left")))[0].fix, HasSubstr("docs/trust.md"));
}

TEST(TrustFindings, TrustOnOneSideOnlyIsNamedOnBothSides) {
  const std::vector<client::Component> there{island_of_trust().island};
  const auto plain = check_other_side(there, true), closed = check_other_side(there, false);
  EXPECT_EQ(plain.at(0).grade, Grade::kProblem);
  EXPECT_THAT(plain.at(0).what, HasSubstr("island 6541 home takes part without trust, this program with"));
  EXPECT_THAT(closed.at(0).what, HasSubstr("island 6541 home has trust, this program takes part without"));
  EXPECT_THAT(check_other_side({}, true), IsEmpty());
}

TEST(TrustFindings, TheEndOfACertificateIsToldInTime) {
  auto seen = island_of_trust();
  EXPECT_THAT(check_island_trust(seen), IsEmpty()) << "it has no trust";
  seen.properties["trust-days-left"] = "30";
  EXPECT_EQ(check_island_trust(seen).at(0).grade, Grade::kGood);
  seen.properties["trust-days-left"] = "29";
  EXPECT_EQ(check_island_trust(seen).at(0).grade, Grade::kNote);
  EXPECT_THAT(check_island_trust(seen).at(0).what, HasSubstr("island 6541 home ends in 29 days"));
  seen.properties["trust-days-left"] = "-1";
  EXPECT_EQ(check_island_trust(seen).at(0).grade, Grade::kProblem);
  EXPECT_THAT(check_island_trust(seen).at(0).fix, HasSubstr("rubicon trust dds renew"));
}

TEST(TrustFindings, WhatRightsRefusedIsToldWithWhereToLook) {
  auto seen = island_of_trust();
  seen.numbers["rights-refused"] = 3;
  const auto found = check_island_trust(seen);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].what, HasSubstr("refused 3 requests by its rights"));
  EXPECT_THAT(found[0].fix, HasSubstr("rubicon trust audit"));
}

TEST(TrustFindings, PeersThatWereRefusedAreToldWithWhereToLook) {
  auto seen = island_of_trust();
  seen.numbers["dds-refused-peers"] = 1;
  const auto found = check_island_trust(seen);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].grade, Grade::kNote);
  EXPECT_THAT(found[0].what, EndsWith("island 6541 home refused 1 peer since its start"));
  EXPECT_THAT(found[0].fix, HasSubstr("its log says which"));
  EXPECT_THAT(check_losses(seen), Not(Contains(Field(&Finding::what, HasSubstr("dds-refused-peers")))));
}

TEST(TrustFindings, TheLastPeerThatWasRefusedIsToldAsTheLogOfTheIslandSays) {
  auto seen = island_of_trust();
  seen.refusal = LogLine{seen.island.id, 7, WallTime(), "warning", "dds", "'desk' was refused: revoked"};
  EXPECT_THAT(check_island_trust(seen), IsEmpty()) << "no peer counts";
  seen.numbers["dds-refused-peers"] = 2;
  const auto found = check_island_trust(seen);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].what,
              ContainsRegex("refused 2 peers since its start; at [0-9: -]+.*: 'desk' was refused: revoked$"));
  EXPECT_THAT(found[0].fix, HasSubstr("`rubicon log --island 6541 --level warning`"));
}

TEST(TrustFindings, TheNewestLineAboutARefusalIsTheLastOfThem) {
  const auto line = [](std::uint64_t number, const char* text, const char* subject = "dds") {
    return LogLine{OwnerId(1), number, {}, {}, subject, text};
  };
  const std::vector<LogLine> lines{line(1, "'desk' was refused: revoked"), line(2, "'lab' was refused: revoked"),
                                   line(3, "the reload was refused", "daemon")};
  EXPECT_EQ(last_refusal(lines).value_or(LogLine()).number, 2U);
  EXPECT_FALSE(last_refusal({lines[2]}));
}

TEST(TrustFindings, ParticipantsThatShowNothingAreCounted) {
  EXPECT_THAT(check_silent_participants(0, 7, true), IsEmpty());
  const auto with = check_silent_participants(2, 7, true), without = check_silent_participants(1, 7, false);
  ASSERT_THAT(with, SizeIs(1));
  EXPECT_THAT(with[0].what, HasSubstr("2 participants of domain 7 show no component to this program: without trust"));
  EXPECT_THAT(without.at(0).what, HasSubstr("1 participant of domain 7 shows no component to this program: with"));
  EXPECT_THAT(without.at(0).fix, HasSubstr("--trust FOLDER"));
}

TEST(TrustFindings, OnPeisNobodyProvesWhoTheyAre) {
  EXPECT_THAT(check_access_with_trust(island_of_trust(), false).what, HasSubstr("takes members only"));
  EXPECT_THAT(check_access_with_trust(island_of_trust(), true).what, HasSubstr("on PEIS no peer proves who it is"));
}

}  // namespace
}  // namespace rubicon::cli
