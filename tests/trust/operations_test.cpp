#include "trust/operations.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "support/folder.h"
#include "support/own_memory.h"
#include "trust/bundle.h"
#include "trust/id_ranges.h"
#include "trust/now.h"
#include "trust/trust_folder.h"

namespace rubicon::trust {
namespace {

namespace fs = std::filesystem;

std::uint64_t seconds_of(WallTime time) {
  return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::seconds>(time.time_since_epoch()).count());
}

/// A realm with island 7 in a folder.
class TrustOperations : public testing::Test {
 protected:
  TrustOperations() {
    const auto made = init(home_, {"Rubicon", {OwnerId{7}}}, kNow);
    EXPECT_TRUE(made) << made.error().text;
    if (made) realm_ = *made;
  }

  Result<Issued> add_desk() const { return add(home_, {"desk", {}, {"panel"}, 100}, kNow); }

  const support::Folder folder_;
  const fs::path home_ = folder_ / "home";
  const fs::path away_ = folder_ / "away";
  RealmIdentity realm_;
};

TEST_F(TrustOperations, InitMakesLocalAndTheIslands) {
  EXPECT_TRUE(realm_.name.starts_with("Rubicon "));
  EXPECT_EQ(realm_.name.size(), 12U);
  EXPECT_EQ(realm_.fingerprint.size(), 16 * 4 + 15U);
  const auto shown = show(home_, kNow);
  ASSERT_TRUE(shown) << shown.error().text;
  EXPECT_EQ(shown->realm.fingerprint, realm_.fingerprint);
  EXPECT_TRUE(shown->has_authority);
  EXPECT_EQ(shown->authority_days_left, kRealmDays);
  ASSERT_EQ(shown->members.size(), 2U);
  EXPECT_EQ(shown->members[0].member.name, "island-7");
  EXPECT_EQ(ranges_text(shown->members[0].member.ids), "00000007-00000007,00200000-002fffff");
  EXPECT_TRUE(shown->members[0].has_key);
  EXPECT_EQ(shown->members[1].member.name, "local");
  EXPECT_TRUE(shown->members[1].member.has_role("admin"));
  EXPECT_EQ(shown->members[1].days_left, kMemberDays);
}

TEST_F(TrustOperations, InitLeavesARealmAlone) {
  const auto key = content_of(home_ / "ca/identity.key");
  const auto again = init(home_, {}, kNow);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kDuplicate);
  EXPECT_EQ(content_of(home_ / "ca/identity.key"), key);
}

TEST_F(TrustOperations, InitRefusesWrongNamesAndClocks) {
  for (const auto* name : {"", "a<b", "O=x", "a,CN=b", " x", "caf\xc3\xa9"})
    EXPECT_FALSE(init(folder_ / "x", {name, {}}, kNow)) << name;
  const auto early = init(folder_ / "x", {}, WallTime());
  ASSERT_FALSE(early);
  EXPECT_NE(early.error().text.find("the clock of this host says 1970-01-01"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(TrustOperations, AMemberJoinsByBundleAndPhrase) {
  const auto issued = add_desk();
  ASSERT_TRUE(issued) << issued.error().text;
  EXPECT_EQ(issued->phrase.view().size(), 29U);
  EXPECT_EQ(issued->bundle.find(issued->phrase.view()), std::string::npos);
  const auto seen = inspect(issued->bundle, kNow);
  ASSERT_TRUE(seen) << seen.error().text;
  EXPECT_EQ(seen->realm.fingerprint, realm_.fingerprint);
  EXPECT_TRUE(seen->has_key);
  const auto joined = join(away_, issued->bundle, issued->phrase.view(), kNow);
  ASSERT_TRUE(joined) << joined.error().text;
  EXPECT_EQ(joined->member, issued->member);
  const auto shown = show(away_, kNow);
  ASSERT_TRUE(shown) << shown.error().text;
  EXPECT_FALSE(shown->has_authority);
  ASSERT_EQ(shown->members.size(), 1U);
  EXPECT_TRUE(shown->members[0].has_key);
  EXPECT_EQ(shown->members[0].days_left, 100);
  EXPECT_FALSE(fs::exists(home_ / "members/desk/key.pem"));
}

TEST_F(TrustOperations, AWrongPhraseWritesNothing) {
  const auto issued = add_desk();
  ASSERT_TRUE(issued);
  const auto wrong = join(away_, issued->bundle, "abcd-efgh-ijkm-npqr-stuv-wxyz", kNow);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::kRefused);
  EXPECT_NE(wrong.error().text.find("the pass phrase does not open it"), std::string::npos);
  EXPECT_EQ(wrong.error().text.find("abcd"), std::string::npos);
  EXPECT_FALSE(fs::exists(away_));
}

/// Or the byte means nothing, such as one of the text in front of a signed document: then the member is the same.
TEST_F(TrustOperations, ABundleWithAChangedByteWritesNothingOrIsTheSameMember) {
  const auto issued = add_desk();
  ASSERT_TRUE(issued);
  const auto& good = issued->bundle;
  std::size_t refused = 0, tried = 0;
  for (std::size_t at = 0; at < good.size(); at += 1 + good.size() / 97, ++tried) {
    auto changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    const auto joined = join(away_, changed, issued->phrase.view(), kNow);
    EXPECT_EQ(fs::exists(away_), joined.has_value()) << at;
    EXPECT_TRUE(!joined || joined->member == issued->member) << at;
    refused += joined ? 0U : 1U;
    fs::remove_all(away_);
  }
  EXPECT_GT(refused, tried / 2) << tried;
  EXPECT_FALSE(join(away_, good.substr(0, good.size() / 2), issued->phrase.view(), kNow));
  EXPECT_FALSE(fs::exists(away_));
}

TEST_F(TrustOperations, ABundleOfAnotherRealmIsNotMixedIn) {
  const auto other = folder_ / "other";
  ASSERT_TRUE(init(other, {}, kNow));
  const auto issued = add(other, {"desk", {}, {}, 10}, kNow);
  ASSERT_TRUE(issued);
  const auto joined = join(home_, issued->bundle, issued->phrase.view(), kNow);
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().code, ErrorCode::kDuplicate);
  EXPECT_NE(joined.error().text.find(realm_.name), std::string::npos) << joined.error().text;
  EXPECT_FALSE(fs::exists(home_ / "members/desk"));
}

TEST_F(TrustOperations, ABundleWithPartsOfAnotherMemberIsRefused) {
  const auto desk = add_desk(), robot = add(home_, {"robot", {}, {}, 10}, kNow);
  ASSERT_TRUE(desk && robot);
  auto mixed = *read_bundle(desk->bundle);
  mixed.papers.permissions.text = read_bundle(robot->bundle)->papers.permissions.text;
  const auto seen = inspect(bundle_text(mixed), kNow);
  ASSERT_FALSE(seen);
  EXPECT_NE(seen.error().text.find("these are the permissions of CN=robot"), std::string::npos) << seen.error().text;
  mixed = *read_bundle(desk->bundle);
  mixed.key = read_bundle(robot->bundle)->key;
  const auto joined = join(away_, bundle_text(mixed), robot->phrase.view(), kNow);
  ASSERT_FALSE(joined);
  EXPECT_NE(joined.error().text.find("the key is not that of the certificate of desk"), std::string::npos);
}

TEST_F(TrustOperations, ABundleWithAnOpenKeyIsRefused) {
  auto bundle = *read_bundle(add_desk()->bundle);
  bundle.key = PrivateKey::make()->pem()->view();
  const auto seen = inspect(bundle_text(bundle), kNow);
  ASSERT_FALSE(seen);
  EXPECT_NE(seen.error().text.find("a key that no pass phrase protects"), std::string::npos) << seen.error().text;
}

TEST_F(TrustOperations, ARequestKeepsItsKeyAtHome) {
  const auto asked = request(away_, "robot");
  ASSERT_TRUE(asked) << asked.error().text;
  const auto key = content_of(away_ / "members/robot/key.pem");
  EXPECT_TRUE(key.starts_with("-----BEGIN PRIVATE KEY-----"));
  EXPECT_TRUE(request(away_, "robot"));
  EXPECT_EQ(content_of(away_ / "members/robot/key.pem"), key);
  MemberOptions options;
  options.roles = {"robots"};
  const auto issued = sign(home_, *asked, options, kNow);
  ASSERT_TRUE(issued) << issued.error().text;
  EXPECT_TRUE(issued->phrase.empty());
  EXPECT_EQ(issued->member.name, "robot");
  const auto elsewhere = join(folder_ / "elsewhere", issued->bundle, "", kNow);
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().code, ErrorCode::kNotFound);
  const auto joined = join(away_, issued->bundle, "", kNow);
  ASSERT_TRUE(joined) << joined.error().text;
  EXPECT_EQ(content_of(away_ / "members/robot/key.pem"), key);
  EXPECT_FALSE(sign(home_, *asked, options, kNow)) << "the name was given";
}

TEST_F(TrustOperations, NamesAndBlocksAreGivenOnce) {
  ASSERT_TRUE(add_desk());
  for (const auto* name : {"desk", "Desk", "local", "everybody", "../x"}) {
    MemberOptions options;
    options.name = name;
    EXPECT_FALSE(add_here(home_, options, kNow)) << name;
  }
  ASSERT_TRUE(revoke(home_, "desk", kNow));
  EXPECT_EQ(add_desk().error().code, ErrorCode::kDuplicate);
  const auto next = add_here(home_, {"next", {}, {}, 10}, kNow);
  ASSERT_TRUE(next) << next.error().text;
  EXPECT_EQ(ranges_text(next->ids), "00400000-004fffff");
}

TEST_F(TrustOperations, ANameIsNoRoleAndARoleNoName) {
  ASSERT_TRUE(add_desk());
  EXPECT_EQ(add_here(home_, {"panel", {}, {}, 10}, kNow).error().code, ErrorCode::kDuplicate);
  EXPECT_EQ(add_here(home_, {"robot", {}, {"desk"}, 10}, kNow).error().code, ErrorCode::kDuplicate);
}

TEST_F(TrustOperations, AnIslandHasOneMember) {
  const auto second = add_here(home_, {"home", OwnerId{7}, {}, 10}, kNow);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().text.find("the member island-7 has the id of island 7"), std::string::npos);
  EXPECT_FALSE(fs::exists(home_ / "members/home"));
  ASSERT_TRUE(revoke(home_, "island-7", kNow));
  EXPECT_TRUE(add_here(home_, {"home", OwnerId{7}, {}, 10}, kNow));
  EXPECT_FALSE(add_here(home_, {"far", OwnerId{65533}, {}, 10}, kNow));
}

TEST_F(TrustOperations, DaysAreBounded) {
  for (const int days : {-1, 0, kMaxMemberDays + 1})
    EXPECT_EQ(add_here(home_, {"x", {}, {}, days}, kNow).error().code, ErrorCode::kOutOfRange) << days;
}

TEST_F(TrustOperations, RevokeListsAllCertificatesOfAMember) {
  ASSERT_TRUE(add_desk());
  ASSERT_TRUE(renew(home_, "desk", 200, kNow));
  const auto list = revoke(home_, "desk", kNow);
  ASSERT_TRUE(list) << list.error().text;
  EXPECT_EQ(content_of(home_ / "revoked.p7s"), *list);
  const auto authority = TrustFolder(home_).authority(kNow);
  ASSERT_TRUE(authority);
  const auto read = read_revoked(*list, authority->realm.permissions_ca, "x");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->number, seconds_of(kNow));
  EXPECT_EQ(read->certificates.size(), 2U);
  const auto shown = show(home_, kNow);
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->members[0].member.name, "desk");
  EXPECT_EQ(shown->members[0].revoked, kNow);
  ASSERT_TRUE(revoke(home_, "desk", kNow)) << "again";
  EXPECT_EQ(show(home_, kNow)->revoked_number, seconds_of(kNow));
  EXPECT_EQ(revoke(home_, "nobody", kNow).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(renew(home_, "desk", 10, kNow).error().code, ErrorCode::kRefused);
}

TEST_F(TrustOperations, ARevokedBundleDoesNotJoinWhereThatIsKnown) {
  const auto desk = add_desk(), robot = add(home_, {"robot", {}, {}, 10}, kNow);
  ASSERT_TRUE(desk && robot);
  ASSERT_TRUE(revoke(home_, "desk", kNow));
  const auto later = export_member(home_, "robot", kNow);
  ASSERT_TRUE(later) << later.error().text;
  ASSERT_TRUE(join(away_, robot->bundle, robot->phrase.view(), kNow));
  ASSERT_TRUE(join(away_, later->bundle, "", kNow)) << "brings the list";
  const auto joined = join(away_, desk->bundle, desk->phrase.view(), kNow);
  ASSERT_FALSE(joined);
  EXPECT_NE(joined.error().text.find("was revoked on 2026-11-23"), std::string::npos) << joined.error().text;
  ASSERT_TRUE(join(away_, robot->bundle, robot->phrase.view(), kNow)) << "an older list";
  EXPECT_EQ(show(away_, kNow)->revoked_number, seconds_of(kNow));
}

TEST_F(TrustOperations, RenewKeepsNameIdsRolesAndKey) {
  const auto issued = add_desk();
  ASSERT_TRUE(issued);
  ASSERT_TRUE(join(away_, issued->bundle, issued->phrase.view(), kNow));
  const auto later = kNow + std::chrono::days(90);
  const auto renewed = renew(home_, "desk", 300, later);
  ASSERT_TRUE(renewed) << renewed.error().text;
  EXPECT_EQ(renewed->member.ids, issued->member.ids);
  EXPECT_EQ(renewed->member.roles, issued->member.roles);
  EXPECT_NE(renewed->member.serial, issued->member.serial);
  EXPECT_EQ(renewed->member.expires, later + std::chrono::days(300));
  EXPECT_TRUE(renewed->phrase.empty());
  ASSERT_TRUE(join(away_, renewed->bundle, "", later));
  EXPECT_EQ(show(away_, later)->members[0].days_left, 300);
  ASSERT_TRUE(renew(home_, "island-7", 300, later));
  EXPECT_EQ(show(home_, later)->members[1].days_left, 300);
}

TEST_F(TrustOperations, AnOlderBundleDoesNotReplaceWhatIsThere) {
  const auto issued = add_desk();
  ASSERT_TRUE(issued);
  const auto renewed = renew(home_, "desk", 300, kNow);
  ASSERT_TRUE(renewed) << renewed.error().text;
  ASSERT_TRUE(join(away_, issued->bundle, issued->phrase.view(), kNow));
  ASSERT_TRUE(join(away_, renewed->bundle, "", kNow));
  const auto joined = join(away_, issued->bundle, issued->phrase.view(), kNow);
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().code, ErrorCode::kDuplicate);
  EXPECT_NE(joined.error().text.find("members/desk/certificate.pem ends on 2027-"), std::string::npos)
      << joined.error().text;
  EXPECT_NE(joined.error().text.find("--older"), std::string::npos);
  EXPECT_EQ(show(away_, kNow)->members[0].days_left, 300);
  EXPECT_TRUE(join(away_, renewed->bundle, "", kNow)) << "the same again";
  ASSERT_TRUE(join(away_, issued->bundle, issued->phrase.view(), kNow, Older::kTake));
  EXPECT_EQ(show(away_, kNow)->members[0].days_left, 100);
}

TEST_F(TrustOperations, AnEndedMemberIsRenewedAndAnEndedRealmIsShown) {
  ASSERT_TRUE(add_desk());
  EXPECT_TRUE(renew(home_, "desk", 10, kNow + std::chrono::days(1000)));
  const auto end = kNow + std::chrono::days(kRealmDays + 1);
  EXPECT_EQ(renew(home_, "desk", 10, end).error().code, ErrorCode::kExpired);
  const auto shown = show(home_, end);
  ASSERT_TRUE(shown) << shown.error().text;
  EXPECT_EQ(shown->authority_days_left, -1);
}

TEST_F(TrustOperations, ExportTakesTheKeyAlongIfItIsThere) {
  const auto island = export_member(home_, "island-7", kNow);
  ASSERT_TRUE(island) << island.error().text;
  ASSERT_TRUE(join(away_, island->bundle, island->phrase.view(), kNow));
  EXPECT_EQ(content_of(away_ / "members/island-7/key.pem"), content_of(home_ / "members/island-7/key.pem"));
  ASSERT_TRUE(add_desk());
  EXPECT_TRUE(export_member(home_, "desk", kNow)->phrase.empty());
  EXPECT_EQ(export_member(home_, "nobody", kNow).error().code, ErrorCode::kNotFound);
}

TEST_F(TrustOperations, WithoutAuthorityNothingIsChanged) {
  const auto issued = add_desk();
  ASSERT_TRUE(join(away_, issued->bundle, issued->phrase.view(), kNow));
  const auto added = add(away_, {"more", {}, {}, 10}, kNow);
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().text.find("ca/identity.key: is not here"), std::string::npos) << added.error().text;
  EXPECT_FALSE(revoke(away_, "desk", kNow));
  EXPECT_FALSE(add(folder_ / "none", {"more", {}, {}, 10}, kNow));
}

TEST_F(TrustOperations, AnAuthorityRestoredFromACopyRevokesWithAHigherNumber) {
  const auto copy = folder_ / "copy";
  ASSERT_TRUE(add_desk() && add(home_, {"robot", {}, {}, 10}, kNow));
  fs::copy(home_, copy, fs::copy_options::recursive);
  ASSERT_TRUE(revoke(home_, "desk", kNow) && revoke(home_, "local", kNow));
  const auto lost = show(home_, kNow)->revoked_number;
  EXPECT_EQ(lost, seconds_of(kNow) + 1) << "grows within a second too";
  ASSERT_TRUE(revoke(copy, "robot", kNow + std::chrono::minutes(1)));
  EXPECT_GT(show(copy, kNow)->revoked_number, lost);
}

/// The process ended after the note in the ledger, or after that of the permissions.
TEST_F(TrustOperations, AMemberThatWasCutShortIsMadeAgain) {
  const auto key = content_of(home_ / "members/island-7/key.pem");
  const auto ids = show(home_, kNow)->members[0].member.ids;
  fs::remove(home_ / "members/island-7/certificate.pem");
  const auto again = add_here(home_, member_of_island(OwnerId{7}), kNow);
  ASSERT_TRUE(again) << again.error().text;
  EXPECT_NE(again->ids, ids) << "a block is never given twice";
  EXPECT_EQ(content_of(home_ / "members/island-7/key.pem"), key);
  EXPECT_EQ(add_here(home_, member_of_island(OwnerId{7}), kNow).error().code, ErrorCode::kDuplicate);
}

TEST_F(TrustOperations, ANameThatLeftTheHostOrWasRevokedIsNotMadeAgain) {
  ASSERT_TRUE(add_desk());
  fs::remove(home_ / "members/desk/certificate.pem");
  EXPECT_EQ(add_desk().error().code, ErrorCode::kDuplicate);
  EXPECT_EQ(add_here(home_, {"desk", {}, {}, 10}, kNow).error().code, ErrorCode::kDuplicate) << "its key is elsewhere";
  ASSERT_TRUE(revoke(home_, "island-7", kNow));
  fs::remove(home_ / "members/island-7/certificate.pem");
  EXPECT_EQ(add_here(home_, member_of_island(OwnerId{7}), kNow).error().code, ErrorCode::kDuplicate);
}

TEST_F(TrustOperations, InitMakesNoFolderForAuthoritiesWhereAHostJoined) {
  const auto issued = add_desk();
  ASSERT_TRUE(join(away_, issued->bundle, issued->phrase.view(), kNow));
  EXPECT_EQ(init(away_, {}, kNow).error().code, ErrorCode::kDuplicate);
  EXPECT_FALSE(fs::exists(away_ / "ca"));
}

TEST_F(TrustOperations, OnlyOneChangesAFolder) {
  const auto lock = FolderFiles(home_).lock();
  ASSERT_TRUE(lock);
  EXPECT_TRUE(show(home_, kNow));
  EXPECT_EQ(add_desk().error().code, ErrorCode::kBusy);
}

TEST_F(TrustOperations, ACertificateThatCannotBeReadHidesNoOther) {
  const auto file = home_ / "members/desk/certificate.pem";
  ASSERT_TRUE(add_desk());
  std::ofstream(file) << "damaged";
  const auto shown = show(home_, kNow);
  ASSERT_TRUE(shown) << shown.error().text;
  EXPECT_EQ(shown->members.size(), 2U);
  ASSERT_EQ(shown->unreadable.size(), 1U);
  EXPECT_EQ(shown->unreadable[0].name, "desk");
  EXPECT_TRUE(shown->unreadable[0].reason.starts_with(file.string())) << shown->unreadable[0].reason;
  EXPECT_FALSE(shown->unreadable[0].revoked);
  EXPECT_TRUE(add(home_, {"robot", {}, {"panel"}, 10}, kNow));
  EXPECT_TRUE(add_here(home_, {"console", {}, {}, 10}, kNow));
  EXPECT_TRUE(renew(home_, "island-7", 10, kNow));
  EXPECT_TRUE(revoke(home_, "console", kNow));
}

TEST_F(TrustOperations, ACertificateThatCannotBeReadMattersToItsMemberAndToIslands) {
  const auto file = (home_ / "members/desk/certificate.pem").string();
  ASSERT_TRUE(add_desk());
  std::ofstream(file) << "damaged";
  EXPECT_EQ(add_desk().error().code, ErrorCode::kDuplicate) << "the name is given";
  EXPECT_TRUE(renew(home_, "desk", 10, kNow).error().text.starts_with(file));
  const auto island = add_here(home_, member_of_island(OwnerId{8}), kNow);
  ASSERT_FALSE(island) << "desk may have that id";
  EXPECT_TRUE(island.error().text.starts_with(file)) << island.error().text;
  EXPECT_NE(island.error().text.find("revoke desk"), std::string::npos) << island.error().text;
  ASSERT_TRUE(revoke(home_, "desk", kNow));
  EXPECT_TRUE(show(home_, kNow)->unreadable.at(0).revoked);
  EXPECT_TRUE(add_here(home_, member_of_island(OwnerId{8}), kNow));
}

/// The list of what was given away is older than the folder: names and ids would be given twice.
TEST_F(TrustOperations, ACertificateThatCannotBeReadHasToBeInTheList) {
  fs::create_directory(home_ / "members/foreign");
  std::ofstream(home_ / "members/foreign/certificate.pem") << "damaged";
  const auto added = add_desk();
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().text.find("members/foreign/certificate.pem"), std::string::npos) << added.error().text;
}

TEST_F(TrustOperations, PhrasesDoNotStayInMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "with a sanitizer the heap is elsewhere";
#endif
  std::string masked;
  {
    const auto issued = add_desk();
    ASSERT_TRUE(issued);
    masked = support::masked_end(issued->phrase.view());
    EXPECT_GE(support::count_in_heap(masked), 1U) << "it is there while it is needed";
    ASSERT_TRUE(join(away_, issued->bundle, issued->phrase.view(), kNow));
  }
  EXPECT_EQ(support::count_in_heap(masked), 0U);
  {
    const auto exported = export_member(home_, "local", kNow);
    ASSERT_TRUE(exported);
    masked = support::masked_end(exported->phrase.view());
  }
  EXPECT_EQ(support::count_in_heap(masked), 0U);
}

}  // namespace
}  // namespace rubicon::trust
