#include "trust/place.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "support/folder.h"
#include "support/host_group.h"
#include "trust/now.h"
#include "trust/operations.h"
#include "trust/started_realm.h"
#include "trust/trust_folder.h"
#include "trust/variable.h"

namespace rubicon::trust {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// This process is the user nobody until its end.
class AsNobody {
 public:
  AsNobody() : is_changed_(::seteuid(65534) == 0) {}
  ~AsNobody() {
    EXPECT_TRUE(!is_changed_ || ::seteuid(0) == 0);
    ::prctl(PR_SET_DUMPABLE, 1);  // the change of the user took it
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  bool is_changed_;
};

/// A realm with island 7 and `local`.
class PlaceTest : public testing::Test {
 protected:
  PlaceTest() { EXPECT_TRUE(init(root_, {"Rubicon", {OwnerId{7}}}, kNow)); }

  /// A member whose key is here.
  void add_one(const std::string& name, OwnerId island = {}, int days = 100) const {
    const auto added = add_here(root_, {name, island, {}, days}, kNow);
    ASSERT_TRUE(added) << added.error().text;
  }
  void revoke_one(const std::string& name) const { ASSERT_TRUE(revoke(root_, name, kNow)) << name; }
  std::string island() const {
    const auto place = place_of_island(root_, OwnerId{7});
    return place ? place->member : place.error().text;
  }
  std::string people() const {
    const auto place = place_in(root_);
    return place ? place->member : place.error().text;
  }

  const support::Folder folder_;
  const fs::path root_ = folder_ / "trust";
};

TEST_F(PlaceTest, PlacesFollowTheEnvironment) {
  const Variable home("HOME", folder_.path());
  {
    const Variable no("RUBICON_TRUST", "no");
    EXPECT_FALSE(place_of_user()->has_value());
    EXPECT_FALSE(default_folder());
  }
  {
    const Variable folder("RUBICON_TRUST", root_.string());
    const auto place = place_of_user();
    ASSERT_TRUE(place && *place);
    EXPECT_EQ((*place)->member, "local");
    EXPECT_EQ(default_folder(), root_);
  }
  {
    const Variable folder("RUBICON_TRUST", folder_ / "none");
    EXPECT_FALSE(place_of_user());
  }
  const Variable unset("RUBICON_TRUST", "");
  fs::create_directories(user_folder().parent_path());
  fs::rename(root_, user_folder());
  const auto place = place_of_user();
  ASSERT_TRUE(place && *place);
  EXPECT_EQ((*place)->folder, user_folder());
}

/// What cannot be seen is not absent: it is an error, and nothing starts open.
TEST_F(PlaceTest, AFolderThatCannotBeSeenIsAnError) {
  const Variable home("HOME", folder_.path()), unset("RUBICON_TRUST", "");
  fs::create_directories(user_folder().parent_path());
  fs::create_symlink(folder_ / "gone", user_folder());
  EXPECT_FALSE(place_of_user()) << "a link to nothing";
  fs::remove(user_folder());
  fs::create_symlink(user_folder(), user_folder());
  EXPECT_FALSE(place_of_user()) << "a link to itself";
  EXPECT_FALSE(place_of_island(user_folder(), OwnerId{7}));
  fs::remove(user_folder());
  fs::create_directory(user_folder());
  EXPECT_TRUE(place_of_user()) << "a request only";
}

TEST_F(PlaceTest, WhoMayNotEnterAFolderGetsTheWayIntoTheGroup) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  const Variable home("HOME", folder_ / "nowhere"), named("RUBICON_TRUST", root_.string());
  ASSERT_EQ(::chmod(root_.c_str(), 0700), 0);
  const AsNobody nobody;
  const auto place = place_of_user();
  const auto island = place_of_island(root_, OwnerId{7});
  ASSERT_FALSE(place || island);
  EXPECT_NE(place.error().text.find("run `sudo adduser"), std::string::npos) << place.error().text;
  EXPECT_EQ(island.error().code, ErrorCode::kRefused) << island.error().text;
}

/// What place_in() says to a user who is nobody.
std::string refusal_of_nobody(const fs::path& folder) {
  const AsNobody nobody;
  const auto place = place_in(folder);
  return place ? "may use " + place->member : place.error().text;
}

TEST_F(PlaceTest, WhoMayNotReadAKeyGetsWhatHelps) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0755), 0);
  const auto init = "`sudo rubicon trust dds init --trust " + root_.string() + "`";
  if (!people_group()) {
    EXPECT_THAT(refusal_of_nobody(root_), AllOf(HasSubstr("this host has no group rubicon"), HasSubstr(init),
                                                HasSubstr("`sudo addgroup --system rubicon`")));
  }
  const support::HostGroup group("rubicon");
  if (!group.exists()) GTEST_SKIP() << group.reason();
  EXPECT_THAT(refusal_of_nobody(root_),
              AllOf(HasSubstr("local/key.pem: is for root only: run " + init), HasSubstr("adduser nobody rubicon")));
  EXPECT_TRUE(give_local_to_people(root_).value_or(false));
  EXPECT_FALSE(give_local_to_people(root_).value_or(true)) << "it is theirs";
  EXPECT_THAT(refusal_of_nobody(root_), HasSubstr("nobody may not use the key of this host: run `sudo adduser"));
  revoke_one("local");
  add_one("panel");
  EXPECT_THAT(refusal_of_nobody(root_), HasSubstr("panel/key.pem: is for root only: `rubicon trust dds join` takes"));
}

TEST_F(PlaceTest, AUnitWithoutAKeyIsToldWhoSaysWhy) {
  const Variable credentials("CREDENTIALS_DIRECTORY", folder_.path());
  std::ofstream(folder_ / "trust-key") << "none\n";
  EXPECT_EQ(island(), "island-7") << "this user may read that of the folder";
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0755), 0);
  const AsNobody nobody;
  const auto place = place_of_island(root_, OwnerId{7});
  ASSERT_FALSE(place);
  EXPECT_EQ(place.error().code, ErrorCode::kRefused);
  EXPECT_THAT(place.error().text, AllOf(HasSubstr("systemd handed over no key (credential trust-key)"),
                                        HasSubstr("`journalctl -u 'rubicon-trust@*'`")));
}

/// A new realm would shut out all members of the former one.
TEST_F(PlaceTest, ARealmThatIsLostIsNotMadeAnew) {
  ASSERT_TRUE(StartedRealm(root_).keep({"Rubicon 5f1c", "AB"}));
  EXPECT_EQ(island(), "island-7");
  fs::rename(root_, folder_ / "lost");
  for (const auto& text : {island(), people()})
    EXPECT_THAT(text, AllOf(HasSubstr("has no realm, but islands of this host started with Rubicon 5f1c"),
                            HasSubstr("put the folder back from your copy")));
}

TEST_F(PlaceTest, ADamagedMemberIsNoReasonAgainstTheOthers) {
  add_one("desk");
  std::ofstream(root_ / "members/desk/certificate.pem") << "damaged";
  EXPECT_TRUE(place_of_island(root_, OwnerId{7}));
  EXPECT_TRUE(place_in(root_));
  EXPECT_FALSE(place_of_island(root_, OwnerId{9}));
}

TEST_F(PlaceTest, OfSeveralStateFoldersTheFirstOneIsUsed) {
  const Variable state("STATE_DIRECTORY", "/var/lib/a:/var/lib/b");
  const auto place = place_of_island(root_, OwnerId{7});
  ASSERT_TRUE(place);
  EXPECT_EQ(place->state, "/var/lib/a");
}

TEST_F(PlaceTest, TheOnlyMemberOfPeopleNeedsNoName) {
  const auto issued = add(root_, {"laptop", {}, {}, 10}, kNow);
  ASSERT_TRUE(issued);
  ASSERT_TRUE(join(folder_ / "away", issued->bundle, issued->phrase.view(), kNow));
  const auto place = place_in(folder_ / "away");
  ASSERT_TRUE(place) << place.error().text;
  EXPECT_EQ(place->member, "laptop");
  EXPECT_FALSE(place_of_island(folder_ / "away", OwnerId{7}));
  const auto missing = place_of_island(root_, OwnerId{9});
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().text, AllOf(HasSubstr("on the host with the authority run `sudo rubicon trust dds init`"),
                                          HasSubstr("`rubicon trust dds add NAME --island 9` there")));
}

/// Whatever their names: `hall` comes before `island-7`, `lounge` after it.
TEST_F(PlaceTest, AnIslandIsNoMemberThatWasRevokedIfThereIsAnother) {
  for (const auto* name : {"hall", "lounge", "attic"}) {
    revoke_one(island());
    add_one(name, OwnerId{7});
    EXPECT_EQ(island(), name);
  }
  revoke_one("attic");
  EXPECT_THAT(island(), testing::AnyOf("hall", "lounge", "attic", "island-7")) << "its start says that it was revoked";
}

TEST_F(PlaceTest, AnIslandIsTheMemberWhoseKeyIsHereAndThatEndsLast) {
  ASSERT_TRUE(revoke(root_, "island-7", kNow));
  add_one("roof", OwnerId{7}, 10);
  const auto later = kNow + std::chrono::days(11);
  ASSERT_TRUE(add_here(root_, {"attic", OwnerId{7}, {}, 100}, later));
  EXPECT_EQ(island(), "attic");
  const auto last = later + std::chrono::days(101);
  ASSERT_TRUE(add(root_, {"cellar", OwnerId{7}, {}, 200}, last)) << "its key is on another host";
  EXPECT_EQ(island(), "attic");
  fs::remove(root_ / "members/attic/key.pem");
  fs::remove(root_ / "members/roof/key.pem");
  fs::remove(root_ / "members/island-7/key.pem");
  EXPECT_EQ(island(), "cellar");
}

TEST_F(PlaceTest, PeopleAreNoMemberThatWasRevokedIfThereIsAnother) {
  add_one("people");
  EXPECT_EQ(people(), "local");
  revoke_one("local");
  EXPECT_EQ(people(), "people");
  add_one("crowd");
  EXPECT_THAT(people(), HasSubstr("has the members crowd and people: expected one, or one called local"));
  revoke_one("crowd");
  EXPECT_EQ(people(), "people");
  revoke_one("people");
  EXPECT_EQ(people(), "local") << "all are revoked, its start says so";
}

TEST_F(PlaceTest, AKeyThatIsForThePeopleOfTheHostComesBeforeOthers) {
  const support::HostGroup group("rubicon");
  if (!group.exists()) GTEST_SKIP() << group.reason();
  revoke_one("local");
  for (const auto* service : {"panel", "robot"}) add_one(service);
  ASSERT_TRUE(add_here(root_, {"people", {}, {}, 10}, kNow, KeyReaders::kPeople));
  EXPECT_EQ(people(), "people");
}

TEST_F(PlaceTest, AListThatCannotBeReadRevokesNobody) {
  revoke_one("island-7");
  add_one("zone", OwnerId{7}, 10);
  EXPECT_EQ(island(), "zone");
  std::ofstream(root_ / "revoked.p7s") << "damaged";
  EXPECT_EQ(island(), "island-7") << "it ends last; its start names the list";
}

}  // namespace
}  // namespace rubicon::trust
