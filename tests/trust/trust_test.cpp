#include "trust/trust.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/folder.h"
#include "trust/guard/guard.h"
#include "trust/now.h"
#include "trust/operations.h"
#include "trust/private_memory.h"
#include "trust/trust_folder.h"
#include "trust/variable.h"

namespace rubicon::trust {
namespace {

namespace fs = std::filesystem;
using std::chrono::days;

constexpr WallTime kStart = std::chrono::sys_days(std::chrono::year(2026) / 1 / 1);  // of VirtualScheduler
constexpr tuples::dds::GuidPrefix kPeer{1};

/// A realm with island 7, `local` and `desk`, and the guard that this test speaks for.
class TrustTest : public testing::Test {
 protected:
  TrustTest() {
    EXPECT_TRUE(init(root_, {"Rubicon", {OwnerId{7}}}, kStart));
    EXPECT_TRUE(add_here(root_, {"desk", {}, {"panel"}, 100}, kStart));
    know({});
  }

  Result<std::shared_ptr<Trust>> open(const std::string& member = "desk") {
    return Trust::open({root_, member, {}, state_}, scheduler_, Log(log_, "trust"));
  }

  /// What the guard says of each peer.
  static void know(const rubicon_guard_peer& peer) {
    void* library = ::dlopen(RUBICON_FAKE_GUARD, RTLD_NOW);
    ASSERT_NE(library, nullptr) << ::dlerror();
    const auto tell = reinterpret_cast<void (*)(const rubicon_guard_peer*)>(::dlsym(library, "fake_guard_know"));
    ASSERT_NE(tell, nullptr);
    tell(&peer);
  }
  static rubicon_guard_peer peer_of(const tuples::Member& member) {
    rubicon_guard_peer peer{};
    member.name.copy(peer.name, sizeof peer.name - 1);
    std::string("admin,panel").copy(peer.roles, sizeof peer.roles - 1);
    std::string("00000007-00000007,01a00000-01afffff").copy(peer.ids, sizeof peer.ids - 1);
    member.serial.copy(peer.serial, sizeof peer.serial - 1);
    peer.expires = std::chrono::floor<std::chrono::seconds>(member.expires).time_since_epoch().count();
    return peer;
  }
  tuples::Member member(const std::string& name) const { return *TrustFolder(root_).member(name); }

  const Variable guard_{"RUBICON_GUARD", RUBICON_FAKE_GUARD};
  const support::Folder folder_;
  const fs::path root_ = folder_ / "trust";
  fs::path state_;
  VirtualScheduler scheduler_;
  support::CollectingLog log_;
};

TEST_F(TrustTest, GivesTheDocumentsOfItsMember) {
  const auto trust = open();
  ASSERT_TRUE(trust) << trust.error().text;
  const auto documents = (*trust)->documents();
  ASSERT_TRUE(documents) << documents.error().text;
  EXPECT_EQ(documents->identity_ca, "file:" + (root_ / "identity-ca.pem").string());
  EXPECT_EQ(documents->certificate, "file:" + (root_ / "members/desk/certificate.pem").string());
  EXPECT_EQ(documents->private_key, "file:" + (root_ / "members/desk/key.pem").string());
  EXPECT_EQ(documents->permissions_ca, "file:" + (root_ / "permissions-ca.pem").string());
  EXPECT_EQ(documents->governance, "file:" + (root_ / "governance.p7s").string());
  EXPECT_EQ(documents->permissions, "file:" + (root_ / "members/desk/permissions.p7s").string());
  EXPECT_EQ((*trust)->own(), member("desk"));
  EXPECT_EQ((*trust)->guard_library(), RUBICON_FAKE_GUARD);
  EXPECT_EQ((*trust)->days_left(), 100);
  EXPECT_EQ((*trust)->revoked(), content_of(root_ / "revoked.p7s"));
  EXPECT_TRUE(log_.lines.empty()) << log_.lines.front();
}

TEST_F(TrustTest, TakesTheKeyThatSystemdHandsOut) {
  const auto key = folder_ / "trust-key";
  fs::rename(root_ / "members/island-7/key.pem", key);
  EXPECT_FALSE(open("island-7"));
  const Variable credentials("CREDENTIALS_DIRECTORY", folder_.path());
  const Variable state("STATE_DIRECTORY", folder_ / "state");
  const auto place = place_of_island(root_, OwnerId{7});
  ASSERT_TRUE(place) << place.error().text;
  EXPECT_EQ(place->member, "island-7");
  EXPECT_EQ(place->key, key);
  EXPECT_EQ(place->state, folder_ / "state");
  const auto trust = Trust::open(*place, scheduler_, Log(log_, "trust"));
  ASSERT_TRUE(trust) << trust.error().text;
  EXPECT_EQ((*trust)->documents()->private_key, "file:" + key);
}

TEST_F(TrustTest, AnotherKeyIsRefused) {
  fs::copy_file(root_ / "members/local/key.pem", root_ / "members/desk/key.pem", fs::copy_options::overwrite_existing);
  const auto trust = open();
  ASSERT_FALSE(trust);
  EXPECT_NE(trust.error().text.find("key.pem: is not the key of CN=desk"), std::string::npos) << trust.error().text;
}

TEST_F(TrustTest, ARenamedMemberIsRefused) {
  fs::rename(root_ / "members/desk", root_ / "members/tower");
  const auto trust = open("tower");
  ASSERT_FALSE(trust);
  EXPECT_NE(trust.error().text.find("is the certificate of desk: expected that of tower"), std::string::npos);
}

TEST_F(TrustTest, WrongClocksAndEndedCertificatesAreNamed) {
  scheduler_.set_wall(WallTime());
  auto trust = open();
  ASSERT_FALSE(trust);
  EXPECT_NE(trust.error().text.find("the clock of this host says 1970-01-01 00:00 UTC"), std::string::npos);
  scheduler_.set_wall(std::chrono::sys_days(std::chrono::year(2100) / 1 / 1));
  trust = open();
  ASSERT_FALSE(trust);
  EXPECT_EQ(trust.error().code, ErrorCode::kExpired);
  EXPECT_NE(trust.error().text.find("2100-01-01"), std::string::npos) << trust.error().text;
  scheduler_.set_wall(kStart + days(101));
  trust = open();
  ASSERT_FALSE(trust);
  EXPECT_NE(trust.error().text.find("CN=desk"), std::string::npos);
  EXPECT_NE(trust.error().text.find("ended on 2026-04-11 00:00 UTC"), std::string::npos) << trust.error().text;
}

TEST_F(TrustTest, WarnsOfItsEndOnceADay) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  const auto pass = [this](int first, int last) {
    for (int day = first; day <= last; ++day) {
      scheduler_.set_wall(kStart + days(day) + std::chrono::hours(1));
      scheduler_.run_for(std::chrono::minutes(1));
    }
  };
  pass(0, 68);
  EXPECT_TRUE(log_.lines.empty()) << log_.lines.front();
  pass(69, 70);
  EXPECT_EQ(log_.lines.size(), 2U);
  EXPECT_TRUE(
      log_.contains("the certificate of desk ends on 2026-04-11 00:00 UTC: run `rubicon trust dds renew desk`"));
  pass(71, 100);
  EXPECT_EQ(log_.lines.size(), 32U);
  EXPECT_TRUE(log_.contains("the certificate of desk ended on"));
  EXPECT_LT((*trust)->days_left(), 0);
}

TEST_F(TrustTest, RenewedDocumentsAreTaken) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  const auto before = (*trust)->own().serial;
  const auto contents = (*trust)->documents()->contents;
  EXPECT_EQ((*trust)->documents()->contents, contents);
  ASSERT_TRUE(renew(root_, "desk", 300, kStart));
  ASSERT_TRUE((*trust)->documents());
  EXPECT_NE((*trust)->documents()->contents, contents);
  EXPECT_NE((*trust)->own().serial, before);
  EXPECT_EQ((*trust)->days_left(), 300);
}

TEST_F(TrustTest, TheGuardSaysWhoAPeerIs) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  EXPECT_FALSE((*trust)->who(kPeer));
  const auto local = member("local");
  know(peer_of(local));
  const auto who = (*trust)->who(kPeer);
  ASSERT_TRUE(who);
  EXPECT_EQ(who->name, "local");
  EXPECT_EQ(who->roles, (std::vector<std::string>{"admin", "panel"}));
  EXPECT_TRUE(who->may_use(OwnerId{7}));
  EXPECT_TRUE(who->may_use(OwnerId{0x1a00001}));
  EXPECT_FALSE(who->may_use(OwnerId{8}));
  EXPECT_EQ(who->serial, local.serial);
  EXPECT_EQ(who->expires, local.expires);
  EXPECT_FALSE((*trust)->who({2}));
}

TEST_F(TrustTest, APeerThatEndedIsNobody) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  know(peer_of(member("local")));
  scheduler_.set_wall(member("local").expires - std::chrono::seconds(1));
  EXPECT_TRUE((*trust)->who(kPeer));
  scheduler_.set_wall(member("local").expires);
  EXPECT_FALSE((*trust)->who(kPeer));
}

TEST_F(TrustTest, APeerWithStrangeIdsIsNobody) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  auto peer = peer_of(member("local"));
  std::fill_n(peer.ids, sizeof peer.ids, 'x');
  know(peer);
  EXPECT_FALSE((*trust)->who(kPeer));
}

TEST_F(TrustTest, ANewListOfRevokedCertificatesIsTakenOnce) {
  const auto trust = open("island-7");
  ASSERT_TRUE(trust);
  know(peer_of(member("desk")));
  ASSERT_TRUE((*trust)->who(kPeer));
  const auto old = content_of(root_ / "revoked.p7s");
  const auto list = revoke(root_, "desk", kStart);
  ASSERT_TRUE(list);
  EXPECT_TRUE((*trust)->take_revoked(*list, "roof"));
  EXPECT_FALSE((*trust)->who(kPeer));
  EXPECT_EQ((*trust)->revoked(), *list);
  EXPECT_TRUE(log_.contains("desk ("));
  EXPECT_FALSE((*trust)->take_revoked(*list, "roof")) << "again";
  EXPECT_FALSE((*trust)->take_revoked(old, "roof")) << "a lower number";
  EXPECT_EQ((*trust)->revoked(), *list);
}

TEST_F(TrustTest, AListOfAnotherSignerIsRefused) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  ASSERT_TRUE(init(folder_ / "other", {}, kStart));
  const auto list = revoke(folder_ / "other", "local", kStart);
  ASSERT_TRUE(list);
  EXPECT_FALSE((*trust)->take_revoked(*list, "roof"));
  EXPECT_FALSE((*trust)->take_revoked("nonsense", "roof"));
  EXPECT_TRUE(log_.contains("was not signed by"));
}

TEST_F(TrustTest, ListsThatAreNoneFillNoLog) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  for (int i = 0; i < 90; ++i) {
    EXPECT_FALSE((*trust)->take_revoked("nonsense " + std::to_string(i), "roof"));
    scheduler_.run_for(std::chrono::seconds(1));
  }
  EXPECT_EQ(log_.lines.size(), 2U) << "one a minute";
  EXPECT_FALSE((*trust)->take_revoked("nonsense", "desk"));
  EXPECT_TRUE(log_.contains("a list of revoked certificates from desk: is no document")) << "each member has its own";
}

TEST_F(TrustTest, AListInTheFolderIsFoundAndReported) {
  const auto trust = open("island-7");
  ASSERT_TRUE(trust);
  int calls = 0;
  (*trust)->watch_revoked([&] { ++calls; });
  scheduler_.run_for(std::chrono::seconds(10));
  EXPECT_EQ(calls, 0);
  const auto list = revoke(root_, "desk", kStart);
  ASSERT_TRUE(list);
  scheduler_.run_for(std::chrono::seconds(10));
  EXPECT_EQ(calls, 1);
  EXPECT_EQ((*trust)->revoked(), *list);
}

TEST_F(TrustTest, AListThatWasHeardIsThereAtTheNextStart) {
  state_ = folder_ / "state";
  fs::create_directory(state_);
  const auto old = content_of(root_ / "revoked.p7s");
  const auto list = revoke(root_, "desk", kStart);
  ASSERT_TRUE(list);
  ASSERT_TRUE(TrustFolder(root_).write_revoked(old));
  {
    const auto trust = open("island-7");
    ASSERT_TRUE(trust);
    ASSERT_TRUE((*trust)->take_revoked(*list, "roof"));
  }
  EXPECT_EQ(content_of(root_ / "revoked.p7s"), *list);
  // A unit that may not write the folder has it in its state.
  ASSERT_TRUE(TrustFolder(root_).write_revoked(old));
  std::ofstream(state_ / "revoked.p7s") << *list;
  const auto trust = open("island-7");
  ASSERT_TRUE(trust);
  EXPECT_EQ((*trust)->revoked(), *list);
  std::ofstream(state_ / "revoked.p7s") << "damaged";
  EXPECT_TRUE(open("island-7"));
  EXPECT_TRUE(log_.contains("revoked.p7s: is no document"));
}

TEST_F(TrustTest, AListThatWasHeardNeverReplacesANewerOne) {
  const auto trust = open("island-7");
  ASSERT_TRUE(trust);
  const auto heard = revoke(root_, "desk", kStart), newer = revoke(root_, "local", kStart);
  ASSERT_TRUE(heard && newer);
  EXPECT_TRUE((*trust)->take_revoked(*heard, "roof"));
  EXPECT_EQ(content_of(root_ / "revoked.p7s"), *newer);
  scheduler_.run_for(std::chrono::seconds(3));
  EXPECT_EQ((*trust)->revoked(), *newer);
}

TEST_F(TrustTest, AListIsKeptWhenTheFolderIsFreeAgain) {
  const auto old = content_of(root_ / "revoked.p7s");
  const auto list = revoke(root_, "desk", kStart);
  ASSERT_TRUE(list && TrustFolder(root_).write_revoked(old));
  const auto trust = open("island-7");
  ASSERT_TRUE(trust);
  {
    const auto lock = FolderFiles(root_).lock();
    ASSERT_TRUE(lock);
    EXPECT_TRUE((*trust)->take_revoked(*list, "roof"));
    EXPECT_EQ(content_of(root_ / "revoked.p7s"), old) << "another program changes the folder";
  }
  scheduler_.run_for(std::chrono::seconds(3));
  EXPECT_EQ(content_of(root_ / "revoked.p7s"), *list);
}

TEST_F(TrustTest, AnIslandThatCannotKeepAListWarnsAndAToolDoesNot) {
  const auto old = content_of(root_ / "revoked.p7s");
  const auto list = revoke(root_, "local", kStart);
  ASSERT_TRUE(list && TrustFolder(root_).write_revoked(old));
  fs::remove(root_ / "lock");
  fs::create_symlink(folder_ / "elsewhere", root_ / "lock");
  struct Warnings final : base::LogSink {
    void write(base::LogLevel level, std::string_view, std::string_view text) override {
      if (level == base::LogLevel::kWarning) all += text;
    }
    std::string all;
  };
  const auto warnings_of = [&](const std::string& name) {
    Warnings warnings;
    const auto trust = Trust::open({root_, name, {}, {}}, scheduler_, Log(warnings, "trust"));
    EXPECT_TRUE(trust && (*trust)->take_revoked(*list, "roof")) << name;
    return warnings.all;
  };
  EXPECT_EQ(warnings_of("desk"), "");
  EXPECT_NE(warnings_of("island-7").find("is forgotten at the next start"), std::string::npos);
}

/// A program on the client library may be one that a debugger or a crash report is for.
TEST_F(TrustTest, LeavesTheProcessAsItIs) {
  ASSERT_TRUE(open());
  EXPECT_EQ(::prctl(PR_GET_DUMPABLE), 1);
}

TEST(PrivateMemory, IsNotWrittenToACoreFile) {
  const auto child = ::fork();
  if (child == 0) {
    keep_memory_private();
    rlimit core{1, 1};
    const bool none = ::getrlimit(RLIMIT_CORE, &core) == 0 && core.rlim_cur == 0 && core.rlim_max == 0;
    ::_exit(none && ::prctl(PR_GET_DUMPABLE) == 0 ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST_F(TrustTest, ARevokedMemberDoesNotStart) {
  ASSERT_TRUE(revoke(root_, "desk", kStart));
  const auto trust = open();
  ASSERT_FALSE(trust);
  EXPECT_EQ(trust.error().code, ErrorCode::kRefused);
  EXPECT_NE(trust.error().text.find("the certificate of desk was revoked on 2026-01-01"), std::string::npos);
}

TEST_F(TrustTest, DocumentsThatAreRefusedChangeNothing) {
  const auto trust = open();
  ASSERT_TRUE(trust);
  const auto before = (*trust)->own();
  ASSERT_TRUE(renew(root_, "desk", 300, kStart));
  ASSERT_TRUE(revoke(root_, "desk", kStart));
  EXPECT_EQ((*trust)->documents().error().code, ErrorCode::kRefused);
  EXPECT_EQ((*trust)->own(), before);
}

TEST_F(TrustTest, AMissingGuardIsNamedOnce) {
  const Variable none("RUBICON_GUARD", folder_ / "none.so");
  const auto trust = open();
  ASSERT_TRUE(trust) << trust.error().text;
  EXPECT_TRUE(log_.contains("none.so: cannot load the guard"));
  EXPECT_FALSE((*trust)->who(kPeer));
  ASSERT_TRUE((*trust)->documents());
  EXPECT_EQ(log_.lines.size(), 1U);
}

/// With a guard that it cannot ask, a process would take part and know nobody.
TEST_F(TrustTest, AGuardOfAnotherVersionIsNoStart) {
  void* library = ::dlopen(RUBICON_FAKE_GUARD, RTLD_NOW);
  ASSERT_NE(library, nullptr) << ::dlerror();
  const auto set_version = reinterpret_cast<void (*)(int)>(::dlsym(library, "fake_guard_set_version"));
  ASSERT_NE(set_version, nullptr);
  set_version(RUBICON_GUARD_VERSION + 1);
  const auto trust = open();
  set_version(RUBICON_GUARD_VERSION);
  ASSERT_FALSE(trust);
  EXPECT_NE(trust.error().text.find("install packages of the same version"), std::string::npos) << trust.error().text;
}

TEST_F(TrustTest, TheBuildHasTheGuardBesideItsPrograms) {
  const Variable none("RUBICON_GUARD", "");
  const auto trust = open();
  ASSERT_TRUE(trust);
  EXPECT_TRUE((*trust)->guard_library().ends_with("/librubicon-guard.so")) << (*trust)->guard_library();
}

}  // namespace
}  // namespace rubicon::trust
