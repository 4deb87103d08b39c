#include "trust/site/site_folder.h"

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "trust/certificate.h"
#include "trust/site/live_realm.h"
#include "trust/site/realm_fixture.h"

namespace rubicon::trust::site {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

SiteRealm sample() {
  SiteRealm realm;
  realm.name = "Rubicon 5f1c";
  realm.number = 1'790'000'000;
  realm.members = {{"hall", {}}, {"ann", {"admin", "ops"}}};
  realm.islands = {{6541, "hall"}};
  realm.revoked = {"desk"};
  return realm;
}

std::string parsed_fault(const std::string& text) {
  const auto realm = parse_realm(text, "input");
  return realm ? "" : realm.error().text;
}

TEST(SiteRealmText, IsWhatWasWritten) {
  const auto text = realm_text(sample());
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, R"({"islands":{"6541":"hall"},"members":{"ann":"admin,ops","hall":""},"name":"Rubicon 5f1c",)"
                   R"("number":1790000000,"revoked":["desk"],"rubicon-realm":1})"
                   "\n");
  const auto again = parse_realm(*text, "input");
  ASSERT_TRUE(again) << again.error().text;
  EXPECT_EQ(*again, sample());
}

TEST(SiteRealmText, NamesAllWhoMayBeAnIsland) {
  auto realm = sample();
  realm.islands.emplace(6541, "ann");
  const auto text = realm_text(realm);
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr(R"("islands":{"6541":"ann hall"})"));
  EXPECT_EQ(*parse_realm(*text, "input"), realm);
}

TEST(SiteRealmText, SaysWhoIsWho) {
  const auto realm = sample();
  EXPECT_EQ(realm.roles_of("ann"), (std::vector<std::string>{"admin", "ops"}));
  EXPECT_THAT(realm.roles_of("stranger"), IsEmpty());
  EXPECT_TRUE(realm.is_member("hall"));
  EXPECT_FALSE(realm.is_member("desk"));
  EXPECT_TRUE(realm.is_revoked("desk"));
}

/// A release that knows more must still be able to shut a member out.
TEST(SiteRealmText, WhatANewerReleaseAddsIsLeftOut) {
  const auto realm = parse_realm(
      R"({"rubicon-realm":1,"name":"R","number":3,"members":{},"islands":{},"revoked":["desk"],"more":{"a":1}})",
      "input");
  ASSERT_TRUE(realm) << realm.error().text;
  EXPECT_TRUE(realm->is_revoked("desk"));
}

TEST(SiteRealmText, AnythingElseIsRefused) {
  const std::string good = R"("name":"R","number":3,"members":{"a":""},"islands":{},"revoked":[])";
  EXPECT_EQ(parsed_fault(R"({"rubicon-realm":1,)" + good + "}"), "");
  for (const std::string& text : {
           std::string(),
           std::string("{}"),
           std::string("[]"),
           "{" + good + "}",
           R"({"rubicon-realm":2,)" + good + "}",
           std::string(R"({"rubicon-realm":1,"name":"R","number":-3,"members":{},"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3.5,"members":{},"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"","number":3,"members":{},"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R\n","number":3,"members":{},"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":[],"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a/b":""},"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":"x,x"},"islands":{},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":1},"islands":{},"revoked":[]})"),
           std::string(
               R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":""},"islands":{"0":"a"},"revoked":[]})"),
           std::string(
               R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":""},"islands":{"70000":"a"},"revoked":[]})"),
           std::string(
               R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":""},"islands":{"7":"b"},"revoked":[]})"),
           std::string(
               R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":""},"islands":{"7":"a a"},"revoked":[]})"),
           std::string(
               R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":""},"islands":{"7":"a "},"revoked":[]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":{"a":""},"islands":{},"revoked":["a"]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":{},"islands":{},"revoked":["b","b"]})"),
           std::string(R"({"rubicon-realm":1,"name":"R","number":3,"members":{},"islands":{},"revoked":[{"b":[]}]})"),
       }) {
    EXPECT_THAT(parsed_fault(text), HasSubstr("input: is not a realm file")) << text;
  }
}

TEST(SiteRealmText, IsBoundedInMembersAndBytes) {
  auto realm = sample();
  for (std::size_t i = 0; realm.revoked.size() <= SiteRealm::kMaxRevoked; ++i)
    realm.revoked.insert(fmt::format("r{}", i));
  EXPECT_EQ(realm_text(realm).error().code, ErrorCode::kBusy);
  realm.revoked.clear();
  for (std::size_t i = 0; realm.members.size() < SiteRealm::kMaxMembers; ++i)
    realm.members.emplace(fmt::format("{:0>64}", i), std::vector<std::string>{"operator"});
  EXPECT_TRUE(realm_text(realm));
  const auto key = PrivateKey::make();
  const auto authority = make_site_authority(realm.name, kNow + std::chrono::days(9), *key);
  ASSERT_TRUE(authority);
  const auto large = sign_realm(realm, *authority, *key);
  ASSERT_FALSE(large) << large->size();
  EXPECT_THAT(large.error().text, HasSubstr("262144 bytes"));
  realm.members.emplace("one-more", std::vector<std::string>());
  EXPECT_EQ(realm_text(realm).error().code, ErrorCode::kBusy);
  EXPECT_THAT(read_realm(std::string(kMaxRealm + 1, 'x'), *authority, "input").error().text,
              HasSubstr("input: has more than 262144 bytes"));
}

TEST(SiteRealmText, AThousandSitesAreSmall) {
  SiteRealm realm;
  realm.name = "Rubicon 5f1c";
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    realm.members.emplace(fmt::format("building-{}", i), std::vector<std::string>{"operator"});
    realm.islands.emplace(i, fmt::format("building-{}", i));
  }
  const auto key = PrivateKey::make();
  const auto authority = make_site_authority(realm.name, kNow + std::chrono::days(9), *key);
  const auto document = sign_realm(realm, *authority, *key);
  ASSERT_TRUE(document);
  EXPECT_LT(document->size(), 60'000U);
  EXPECT_EQ(*read_realm(*document, *authority, "input"), realm);
}

TEST(SignedSiteRealm, OnlyTheAuthorityOfThisRealmSignsIt) {
  const auto key = PrivateKey::make(), other_key = PrivateKey::make();
  const auto ends = kNow + std::chrono::days(9);
  const auto authority = make_site_authority("Rubicon 5f1c", ends, *key);
  const auto stranger = make_site_authority("Rubicon 5f1c", ends, *other_key);
  const auto document = sign_realm(sample(), *authority, *key);
  ASSERT_TRUE(document) << document.error().text;
  EXPECT_EQ(*read_realm(*document, *authority, "input"), sample());
  EXPECT_THAT(read_realm(*document, *stranger, "input").error().text, HasSubstr("was not signed by"));
  auto changed = *document;
  changed.replace(changed.find("desk"), 4, "dusk");
  EXPECT_FALSE(read_realm(changed, *authority, "input"));
  const auto member = issue_member({"hall", ends, other_key->get()}, *authority, *key);
  const auto by_member = sign_text(*realm_text(sample()), *member, *other_key);
  ASSERT_TRUE(by_member);
  EXPECT_FALSE(read_realm(*by_member, *authority, "input")) << "a member signs nothing for others";
  EXPECT_FALSE(read_realm(*sign_text("{}\n", *authority, *key), *authority, "input"));
  EXPECT_FALSE(read_realm(*realm_text(sample()), *authority, "input")) << "not signed at all";
  auto other_name = sample();
  other_name.name = "Rubicon ffff";
  EXPECT_THAT(read_realm(*sign_realm(other_name, *authority, *key), *authority, "input").error().text,
              HasSubstr("is of the realm Rubicon ffff"));
}

/// What a process of another host knows of the realm.
class KnownSiteRealm : public SiteRealms {
 protected:
  KnownSiteRealm() {
    const auto issued = added("hall", {}, {OwnerId{7}});
    EXPECT_TRUE(join_site(away_, issued.bundle, issued.phrase.view(), kNow));
    std::filesystem::create_directory(place_.state);
  }
  std::string document() const { return content_of(home_ / kRealmFile); }
  KnownRealm known() const {
    auto opened = KnownRealm::open(place_, kNow);
    if (!opened) throw std::runtime_error(opened.error().text);
    return std::move(*opened);
  }

  const SitePlace place_{away_, "hall", folder_ / "state"};
};

TEST_F(KnownSiteRealm, TakesWhatIsNewerAndKeepsItOverARestart) {
  auto realm = known();
  EXPECT_EQ(*realm.take(document(), "lab"), false) << "the same";
  const auto before = document();
  added("desk");
  ASSERT_TRUE(revoke(home_, "desk", kNow));
  EXPECT_EQ(*realm.take(document(), "lab"), true);
  EXPECT_TRUE(realm.realm().is_revoked("desk"));
  EXPECT_EQ(realm.document(), document());
  EXPECT_EQ(*realm.take(before, "lab"), false) << "an older one changes nothing";
  EXPECT_TRUE(realm.realm().is_revoked("desk"));
  EXPECT_TRUE(known().realm().is_revoked("desk"));
}

TEST_F(KnownSiteRealm, AFolderThatMayNotBeWrittenIsNoReasonToForget) {
  added("desk");
  ASSERT_TRUE(revoke(home_, "desk", kNow));
  const auto lock = FolderFiles(away_).lock(Duration(0));
  ASSERT_TRUE(lock) << "others hold the folder";
  auto realm = known();
  EXPECT_EQ(*realm.take(document(), "lab"), true);
  EXPECT_FALSE(this->realm(away_).is_revoked("desk"));
  EXPECT_TRUE(known().realm().is_revoked("desk")) << "it is in the state folder";
  std::ofstream(folder_ / "state/realm.p7s") << "damaged";
  EXPECT_FALSE(known().realm().is_revoked("desk")) << "as if there were none";
}

TEST_F(KnownSiteRealm, RefusesWhatOthersMadeUp) {
  auto realm = known();
  const auto before = realm.document();
  const auto other = folder_ / "other";
  ASSERT_TRUE(init(other, {"Rubicon", {}}, kNow));
  const auto strange = realm.take(content_of(std::filesystem::path(other) / kRealmFile), "lab");
  ASSERT_FALSE(strange);
  EXPECT_THAT(strange.error().text, HasSubstr("lab: "));
  EXPECT_FALSE(realm.take("", "lab"));
  EXPECT_FALSE(realm.take(std::string(kMaxRealm + 1, 'x'), "lab"));
  EXPECT_EQ(realm.document(), before);
}

TEST_F(KnownSiteRealm, LooksForANewerOneInItsFolder) {
  auto realm = known();
  EXPECT_FALSE(realm.look());
  added("desk");
  std::filesystem::copy_file(home_ / kRealmFile, away_ / kRealmFile, std::filesystem::copy_options::overwrite_existing);
  EXPECT_TRUE(realm.look());
  EXPECT_TRUE(realm.realm().is_member("desk"));
  EXPECT_FALSE(realm.look());
  std::ofstream(away_ / kRealmFile) << "damaged";
  EXPECT_FALSE(realm.look());
  EXPECT_TRUE(realm.realm().is_member("desk"));
}

/// The same for as long as a process runs.
class LiveSiteRealm : public KnownSiteRealm {
 protected:
  LiveSiteRealm() {
    time_.set_wall(kNow);
    auto opened = LiveRealm::open(place_.authority(), "hall", time_, base::Log(log_, "mqtt"));
    if (!opened || !*opened) throw std::runtime_error(opened ? "none" : opened.error().text);
    realm_ = std::move(*opened);
  }
  void copy_to_away() const {
    std::filesystem::copy_file(home_ / kRealmFile, away_ / kRealmFile,
                               std::filesystem::copy_options::overwrite_existing);
  }

  VirtualScheduler time_;
  support::CollectingLog log_;
  std::shared_ptr<LiveRealm> realm_;
};

TEST_F(LiveSiteRealm, IsNoneBesideAnotherAuthority) {
  EXPECT_EQ(LiveRealm::open(folder_ / "ca.pem", "hall", time_, base::Log(log_, "mqtt")).value(), nullptr);
  EXPECT_EQ(LiveRealm::open("", "hall", time_, base::Log(log_, "mqtt")).value(), nullptr);
}

TEST_F(LiveSiteRealm, SaysWhoAUserIsAndKeepsWhoIsAsBefore) {
  const auto hall = realm_->member("hall");
  ASSERT_TRUE(hall);
  EXPECT_TRUE(hall->may_use(OwnerId{7}));
  EXPECT_TRUE(hall->may_use(OwnerId{70'000}));
  EXPECT_FALSE(hall->may_use(OwnerId{8}));
  EXPECT_EQ(realm_->member("desk"), nullptr);
  added("desk", {"ops"});
  EXPECT_EQ(realm_->take(document(), "lab"), tuples::UserRealm::Taken::kNewer);
  EXPECT_TRUE(realm_->member("desk")->has_role("ops"));
  EXPECT_EQ(realm_->member("hall"), hall);
  EXPECT_EQ(realm_->take(document(), "lab"), tuples::UserRealm::Taken::kOlder);
  EXPECT_EQ(realm_->take("made up", "lab"), tuples::UserRealm::Taken::kWrong);
}

TEST_F(LiveSiteRealm, FindsWhatWasWrittenIntoItsFolderInTime) {
  int changes = 0;
  auto watch = realm_->watch([&] { ++changes; });
  added("desk");
  copy_to_away();
  time_.run_for(LiveRealm::kLook);
  EXPECT_EQ(changes, 1);
  EXPECT_TRUE(realm_->member("desk"));
  time_.run_for(10 * LiveRealm::kLook);
  EXPECT_EQ(changes, 1);
  ASSERT_TRUE(revoke(home_, "hall", kNow));
  copy_to_away();
  watch.reset();
  time_.run_for(LiveRealm::kLook);
  EXPECT_EQ(changes, 1) << "nobody is told any longer";
  EXPECT_EQ(realm_->member("hall"), nullptr);
  EXPECT_TRUE(log_.contains("hall was shut out of the realm"));
}

}  // namespace
}  // namespace rubicon::trust::site
