#include "trust/site/site_operations.h"

#include "trust/site/realm_fixture.h"
#include "trust/site/site_identity.h"
#include "trust/site/site_members.h"
#include "trust/site/site_proofs.h"

namespace rubicon::trust::site {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST_F(SiteRealms, InitMakesOneAuthorityAndAnEmptyRealm) {
  const auto there = contents_of(home_, kNow);
  ASSERT_TRUE(there) << there.error().text;
  EXPECT_TRUE(there->realm.name.starts_with("Rubicon "));
  EXPECT_EQ(there->realm.fingerprint.size(), 16 * 4 + 15U);
  EXPECT_TRUE(there->has_authority);
  EXPECT_EQ(there->authority_days_left, 7305) << "20 years";
  EXPECT_THAT(there->members, IsEmpty());
  EXPECT_THAT(there->hosts, ElementsAre("broker.test"));
  EXPECT_EQ(mode_of(home_ / "ca"), "700");
  EXPECT_EQ(mode_of(home_ / "ca/authority.key"), "600");
  EXPECT_EQ(mode_of(home_ / "realm.p7s"), "644");
  EXPECT_EQ(init(home_, {}, kNow).error().code, ErrorCode::kDuplicate);
  EXPECT_EQ(init(folder_ / "x", {"Rubicon", {"http://broker"}}, kNow).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(init(folder_ / "x", {"a/b", {}}, kNow).error().code, ErrorCode::kInvalid);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(SiteRealms, AMemberJoinsByBundleAndPhrase) {
  const auto issued = added("hall", {"ops"}, {OwnerId{6541}});
  EXPECT_EQ(issued.bundle.find(issued.phrase.view()), std::string::npos);
  EXPECT_THAT(issued.bundle, Not(HasSubstr("BEGIN PRIVATE KEY")));
  const auto shown = inspect_bundle(issued.bundle, kNow);
  ASSERT_TRUE(shown) << shown.error().text;
  EXPECT_EQ(shown->member.name, "hall");
  EXPECT_THAT(shown->member.islands, ElementsAre(OwnerId{6541}));
  EXPECT_THAT(shown->brokers, ElementsAre("broker.test:8883"));
  EXPECT_TRUE(shown->needs_phrase);
  EXPECT_EQ(join_site(away_, issued.bundle, "wrong", kNow).error().code, ErrorCode::kRefused);
  EXPECT_FALSE(fs::exists(away_));
  const auto joined = join_site(away_, issued.bundle, issued.phrase.view(), kNow);
  ASSERT_TRUE(joined) << joined.error().text;
  EXPECT_EQ(mode_of(away_ / "members/hall/key.pem"), "600");
  EXPECT_EQ(realm(away_), realm(home_));
}

TEST_F(SiteRealms, NamesAreGivenOnce) {
  added("hall", {"ops"}, {OwnerId{7}});
  EXPECT_THAT(refused({"hall", {}, {}, 1}).text, HasSubstr("rubicon trust change"));
  EXPECT_THAT(refused({"HALL", {}, {}, 1}).text, HasSubstr("was used before"));
  ASSERT_TRUE(revoke(home_, "hall", kNow));
  EXPECT_THAT(refused({"hall", {}, {}, 1}).text, HasSubstr("was used before"));
  EXPECT_THAT(refused({"a/b", {}, {}, 1}).text, HasSubstr("another level of a topic"));
}

TEST_F(SiteRealms, AnIslandAndAWordHaveOneMeaning) {
  added("hall", {"ops"}, {OwnerId{7}});
  EXPECT_EQ(refused({"lab", {OwnerId{70'000}}, {}, 1}).code, ErrorCode::kOutOfRange);
  EXPECT_THAT(refused({"ops", {}, {}, 1}).text, HasSubstr("is a role of hall"));
  EXPECT_THAT(refused({"lab", {}, {"hall"}, 1}).text, HasSubstr("is the name of a member"));
  EXPECT_THAT(refused({"lab", {}, {"everybody"}, 1}).text, HasSubstr("not a role"));
  EXPECT_THAT(refused({"island-8", {OwnerId{9}}, {}, 1}).text, HasSubstr("expected --island 8"));
  EXPECT_EQ(refused({"lab", {}, {}, 0}).code, ErrorCode::kOutOfRange);
  EXPECT_EQ(realm(home_).members.size(), 1U) << "nothing was made";
}

TEST_F(SiteRealms, TheNumberOfTheRealmOnlyGrows) {
  const auto first = realm(home_).number;
  added("hall");
  const auto second = realm(home_).number;
  EXPECT_GT(second, first);
  const auto later = add(home_, {"lab", {}, {}, 1}, kNow + std::chrono::hours(1));
  ASSERT_TRUE(later);
  EXPECT_EQ(realm(home_).number, first + 3600) << "an authority that was restored goes on with the time";
}

TEST_F(SiteRealms, RolesAndIslandsAreChanged) {
  added("hall", {"ops"}, {OwnerId{7}});
  ASSERT_TRUE(change(home_, "hall", std::vector<std::string>{"admin"}, {}, kNow));
  EXPECT_THAT(realm(home_).roles_of("hall"), ElementsAre("admin"));
  EXPECT_THAT(realm(home_).members_of(OwnerId{7}), ElementsAre("hall"));
  ASSERT_TRUE(change(home_, "hall", {}, std::vector<OwnerId>{OwnerId{8}, OwnerId{9}}, kNow));
  EXPECT_THAT(realm(home_).members_of(OwnerId{7}), IsEmpty());
  EXPECT_THAT(realm(home_).members_of(OwnerId{9}), ElementsAre("hall"));
  EXPECT_THAT(realm(home_).roles_of("hall"), ElementsAre("admin"));
  EXPECT_EQ(change(home_, "lab", {}, {}, kNow).error().code, ErrorCode::kNotFound);
}

/// Of several carriers of one robot each has its id.
TEST_F(SiteRealms, AnIslandIsGivenToSeveralMembersAndTheySayIt) {
  added("hall", {}, {OwnerId{6}, OwnerId{7}});
  const auto lab = add(home_, {"lab", {OwnerId{7}}, {}, 1}, kNow);
  ASSERT_TRUE(lab) << lab.error().text;
  EXPECT_THAT(lab->member.also, ElementsAre("hall"));
  EXPECT_THAT(realm(home_).members_of(OwnerId{7}), ElementsAre("hall", "lab"));
  ASSERT_TRUE(revoke(home_, "hall", kNow));
  EXPECT_THAT(realm(home_).members_of(OwnerId{7}), ElementsAre("lab"));
}

TEST_F(SiteRealms, WhoIsRevokedIsNoMemberAnyMore) {
  const auto issued = added("desk", {"admin"}, {OwnerId{7}});
  ASSERT_TRUE(revoke(home_, "desk", kNow));
  const auto after = realm(home_);
  EXPECT_TRUE(after.is_revoked("desk"));
  EXPECT_FALSE(after.is_member("desk"));
  EXPECT_THAT(after.members_of(OwnerId{7}), IsEmpty()) << "its island is free";
  EXPECT_EQ(renew(home_, "desk", 10, RenewKey::kKeep, kNow).error().code, ErrorCode::kRefused);
  EXPECT_TRUE(revoke(home_, "desk", kNow)) << "again, for a broker whose files could not be written";
  EXPECT_EQ(revoke(home_, "nobody", kNow).error().code, ErrorCode::kNotFound);
  // A bundle from before is of no use where the newer realm is known.
  const auto other = added("lab");
  ASSERT_TRUE(join_site(away_, other.bundle, other.phrase.view(), kNow));
  const auto late = join_site(away_, issued.bundle, issued.phrase.view(), kNow);
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().text, HasSubstr("desk was revoked"));
}

TEST_F(SiteRealms, ACertificateIsRenewedForTheSameKey) {
  const auto issued = added("hall");
  ASSERT_TRUE(join_site(away_, issued.bundle, issued.phrase.view(), kNow));
  const auto renewed = renew(home_, "hall", 400, RenewKey::kKeep, kNow);
  ASSERT_TRUE(renewed) << renewed.error().text;
  EXPECT_TRUE(renewed->issued.phrase.empty());
  EXPECT_THAT(renewed->issued.bundle, Not(HasSubstr("PRIVATE KEY")));
  const auto joined = join_site(away_, renewed->issued.bundle, "", kNow);
  ASSERT_TRUE(joined) << joined.error().text;
  EXPECT_EQ(joined->member.ends, kNow + std::chrono::days(400));
  EXPECT_EQ(join_site(away_, issued.bundle, issued.phrase.view(), kNow).error().code, ErrorCode::kDuplicate) << "older";
  EXPECT_TRUE(join_site(away_, issued.bundle, issued.phrase.view(), kNow, Older::kTake));
  EXPECT_EQ(join_site(folder_ / "x", renewed->issued.bundle, "", kNow).error().code, ErrorCode::kNotFound) << "no key";
}

TEST_F(SiteRealms, AKeyThatWasLostIsReplacedAndTheOldOneRevoked) {
  const auto issued = added("hall");
  ASSERT_TRUE(SiteLedger::read(SiteFolder(home_))->revoked(kNow).empty());
  const auto renewed = renew(home_, "hall", 400, RenewKey::kMake, kNow);
  ASSERT_TRUE(renewed) << renewed.error().text;
  EXPECT_EQ(SiteLedger::read(SiteFolder(home_))->revoked(kNow).size(), 1U);
  EXPECT_TRUE(realm(home_).is_member("hall"));
  EXPECT_TRUE(join_site(away_, renewed->issued.bundle, renewed->issued.phrase.view(), kNow));
}

TEST_F(SiteRealms, AMemberOfThisHostKeepsItsKeyThere) {
  const auto made = add_here(home_, {"hall", {OwnerId{7}}, {}, 100}, kNow);
  ASSERT_TRUE(made) << made.error().text;
  EXPECT_TRUE(made->has_key);
  const auto renewed = renew(home_, "hall", 400, RenewKey::kKeep, kNow);
  ASSERT_TRUE(renewed) << renewed.error().text;
  EXPECT_EQ(renewed->issued.bundle, "") << "all is in the folder";
  EXPECT_EQ(renew(home_, "hall", 400, RenewKey::kMake, kNow).error().code, ErrorCode::kUnsupported);
}

TEST_F(SiteRealms, APasswordIsThePhraseOfItsMember) {
  const auto added = add_with_password(home_, {"ann", {}, {"ops"}, kMemberDays}, kNow);
  ASSERT_TRUE(added) << added.error().text;
  const auto& issued = added->issued;
  EXPECT_TRUE(issued.member.has_password);
  EXPECT_EQ(issued.bundle.find(issued.phrase.view()), std::string::npos);
  EXPECT_EQ(join_site(away_, issued.bundle, "abcd", kNow).error().code, ErrorCode::kRefused);
  std::string typed(issued.phrase.view());
  std::transform(typed.begin(), typed.end(), typed.begin(), [](unsigned char c) { return std::toupper(c); });
  std::erase(typed, '-');
  ASSERT_TRUE(join_site(away_, issued.bundle, typed, kNow)) << "as a person types it";
  EXPECT_EQ(content_of(away_ / "members/ann/password"), std::string(issued.phrase.view()) + "\n");
  EXPECT_EQ(mode_of(away_ / "members/ann/password"), "600");
  EXPECT_EQ(renew(home_, "ann", 10, RenewKey::kKeep, kNow).error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(realm(home_).roles_of("ann"), ElementsAre("ops"));
}

TEST_F(SiteRealms, BundlesOfEarlierReleasesAndOfOtherRealmsAreToldApart) {
  EXPECT_THAT(inspect_bundle(R"({"rubicon-trust": 1})", kNow).error().text,
              HasSubstr("is of the certificates for DDS of an earlier release"));
  const auto issued = added("hall");
  const auto other = folder_ / "other";
  ASSERT_TRUE(init(other, {}, kNow));
  EXPECT_EQ(join_site(other, issued.bundle, issued.phrase.view(), kNow).error().code, ErrorCode::kDuplicate);
  EXPECT_THAT(join_site(away_, "{}", "", kNow).error().text, HasSubstr("expected a file of `rubicon trust add`"));
}

TEST_F(SiteRealms, WhatWasChangedInABundleIsRefused) {
  const auto issued = added("hall");
  const auto read = read_site_bundle(issued.bundle);
  ASSERT_TRUE(read);
  const auto lab = added("lab");
  const auto foreign = read_site_bundle(lab.bundle);
  ASSERT_TRUE(foreign);
  auto mixed = *read;
  mixed.key = foreign->key;
  EXPECT_THAT(join_site(away_, bundle_text(mixed), lab.phrase.view(), kNow).error().text,
              HasSubstr("the key does not belong to the certificate"));
  const auto other = folder_ / "other";
  ASSERT_TRUE(init(other, {}, kNow));
  mixed = *read;
  mixed.authority = content_of(fs::path(other) / kAuthorityFile);
  EXPECT_FALSE(join_site(away_, bundle_text(mixed), issued.phrase.view(), kNow));
  mixed = *read;
  mixed.realm = content_of(fs::path(other) / kRealmFile);
  EXPECT_FALSE(join_site(away_, bundle_text(mixed), issued.phrase.view(), kNow));
  EXPECT_FALSE(fs::exists(away_));
  EXPECT_EQ(inspect_bundle(issued.bundle, kNow + std::chrono::days(101)).error().code, ErrorCode::kExpired);
}

TEST(SitePasswords, AreThoseOfMosquitto) {
  // mosquitto_passwd -b of mosquitto 2.0.11, for the password `secret`.
  EXPECT_TRUE(is_password_of("secret",
                             "$7$101$XYss3nLBlyff0oYU$hxAmwZmcQbv26yDUlvT9kp+HBTIYRozh2dm/DorN"
                             "cXaI/VNGBe1YBQYNezmYJbdjE1YTTgYnwCbEaf8MxuTySQ=="));
  const auto made = password_hash("secret");
  ASSERT_TRUE(made);
  EXPECT_TRUE(made->starts_with("$7$101$"));
  EXPECT_TRUE(is_password_of("secret", *made));
  EXPECT_FALSE(is_password_of("Secret", *made));
  for (const auto* wrong : {"", "$6$a$b", "$7$", "$7$0$AAAAAAAAAAAAAAAA$", "$7$99999999999$AAAAAAAAAAAAAAAA$x"})
    EXPECT_FALSE(is_password_of("secret", wrong)) << wrong;
  EXPECT_EQ(parse_passwords("# x\n\nann:$7$a\nbob:$6$b\n", "f")->size(), 2U);
  EXPECT_THAT(parse_passwords("ann:$7$a\nhall/c1:$7$b\n", "f").error().text,
              AllOf(HasSubstr("f:2: "), HasSubstr("another level of a topic")));
  EXPECT_THAT(parse_passwords("ann:plain\n", "f").error().text, HasSubstr("mosquitto_passwd"));
}

}  // namespace
}  // namespace rubicon::trust::site
