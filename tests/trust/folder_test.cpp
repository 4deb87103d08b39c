#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <sstream>

#include "support/folder.h"
#include "support/host_group.h"
#include "trust/issuer.h"
#include "trust/now.h"
#include "trust/operations.h"
#include "trust/trust_folder.h"

namespace rubicon::trust {
namespace {

namespace fs = std::filesystem;

void overwrite(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

mode_t mode_of(const fs::path& path) {
  struct stat about {};
  EXPECT_EQ(::lstat(path.c_str(), &about), 0) << path;
  return about.st_mode & 07777;
}

/// A realm with island 7.
class TrustFolderTest : public testing::Test {
 protected:
  TrustFolderTest() {
    const auto made = init(root_, {"Rubicon", {OwnerId{7}}}, kNow);
    EXPECT_TRUE(made) << made.error().text;
  }

  /// All that a daemon and the host of the authority read of the folder.
  Result<void> read_all() const {
    const auto issuer = Issuer::open(root_, kNow);
    if (!issuer) return fail(issuer.error());
    for (const auto* member : {"island-7", "local"}) {
      const auto papers = trust_.papers(member);
      if (!papers) return fail(papers.error());
      const auto checked = check_papers(*papers, kNow);
      if (!checked) return fail(checked.error());
      const auto pem = trust_.files().read_key(key_file(member));
      if (!pem) return fail(pem.error());
      const auto key = PrivateKey::of_pem(pem->view(), trust_.files().path(key_file(member)));
      if (!key) return fail(key.error());
      if (!checked->certificate.has_key(key->get())) return fail(ErrorCode::kInvalid, papers->certificate.where);
    }
    return {};
  }

  const support::Folder folder_;
  const fs::path root_ = folder_ / "trust";
  const TrustFolder trust_{root_};
};

TEST_F(TrustFolderTest, HasTheModesOfTheTable) {
  const std::map<std::string, mode_t> modes{
      {"", 0755},
      {"ca", 0700},
      {"ca/identity.key", 0600},
      {"ca/permissions.key", 0600},
      {"ca/blocks", 0600},
      {"ca/members", 0600},
      {"identity-ca.pem", 0644},
      {"permissions-ca.pem", 0644},
      {"governance.p7s", 0644},
      {"revoked.p7s", 0644},
      {"lock", 0600},
      {"members", 0755},
      {"members/island-7", 0755},
      {"members/island-7/certificate.pem", 0644},
      {"members/island-7/permissions.p7s", 0644},
      {"members/island-7/key.pem", 0600},
      {"members/local", 0755},
      {"members/local/certificate.pem", 0644},
      {"members/local/permissions.p7s", 0644},
      {"members/local/key.pem", ::geteuid() == 0 && people_group() ? 0640 : 0600}};
  std::size_t seen = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root_)) {
    const auto name = fs::relative(entry.path(), root_).string();
    ASSERT_TRUE(modes.contains(name)) << name;
    EXPECT_EQ(mode_of(entry.path()), modes.at(name)) << name;
    ++seen;
  }
  EXPECT_EQ(seen, modes.size() - 1);
  EXPECT_EQ(mode_of(root_), 0755U);
}

TEST_F(TrustFolderTest, ModesDoNotDependOnTheUmask) {
  const auto before = ::umask(0777);
  const auto made = init(folder_ / "strict", {}, kNow);
  ::umask(0);
  const auto open = init(folder_ / "open", {}, kNow);
  ::umask(before);
  ASSERT_TRUE(made && open);
  for (const auto* name : {"strict", "open"}) {
    EXPECT_EQ(mode_of(fs::path(folder_ / name) / "ca"), 0700U);
    EXPECT_EQ(mode_of(fs::path(folder_ / name) / "ca/identity.key"), 0600U);
    EXPECT_EQ(mode_of(fs::path(folder_ / name) / "identity-ca.pem"), 0644U);
  }
}

/// Every third byte of every file, another bit each time: a file that was changed is refused by its name, or what it
/// says is the same.
TEST_F(TrustFolderTest, AChangedByteIsRefusedOrHarmless) {
  ASSERT_TRUE(read_all()) << read_all().error().text;
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root_)) {
    if (entry.is_regular_file() && entry.path().filename() != kLockFile) files.push_back(entry.path());
  }
  ASSERT_EQ(files.size(), 14U);
  for (const auto& path : files) {
    const auto good = content_of(path);
    std::size_t refused = 0, tried = 0;
    for (std::size_t at = 0; at < good.size(); at += good.size() < 100 ? 1U : 29U, ++tried) {
      auto bad = good;
      bad[at] = static_cast<char>(bad[at] ^ (1 << (at % 7)));
      overwrite(path, bad);
      const auto read = read_all();
      if (read) continue;
      ++refused;
      const bool named = read.error().text.find(path.filename().string()) != std::string::npos;
      EXPECT_TRUE(named) << path << " at " << at << ": " << read.error().text;
      if (good.find("PRIVATE KEY") != good.npos) {
        EXPECT_EQ(read.error().text.find(good.substr(60, 20)), std::string::npos) << "the content is shown";
      }
    }
    overwrite(path, good);
    EXPECT_GE(refused, tried / (path.filename() == "blocks" ? 4 : 2)) << path;
  }
  EXPECT_TRUE(read_all());
}

TEST_F(TrustFolderTest, AFileOfAnotherRealmIsRefused) {
  const fs::path other = folder_ / "other";
  ASSERT_TRUE(init(other, {"Rubicon", {OwnerId{7}}}, kNow));
  for (const auto* name : {"identity-ca.pem", "permissions-ca.pem", "governance.p7s", "revoked.p7s", "ca/identity.key",
                           "ca/permissions.key", "ca/members", "members/local/certificate.pem",
                           "members/local/permissions.p7s", "members/local/key.pem"}) {
    const auto good = content_of(root_ / name);
    overwrite(root_ / name, content_of(other / name));
    EXPECT_FALSE(read_all()) << name;
    overwrite(root_ / name, good);
  }
  EXPECT_TRUE(read_all());
}

TEST_F(TrustFolderTest, PermissionsOfAnotherMemberAreRefused) {
  overwrite(root_ / "members/local/permissions.p7s", content_of(root_ / "members/island-7/permissions.p7s"));
  const auto read = read_all();
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().text.find("these are the permissions of CN=island-7"), std::string::npos) << read.error().text;
}

TEST_F(TrustFolderTest, ADocumentInThePlaceOfAnotherIsRefused) {
  for (const auto* name : {"governance.p7s", "revoked.p7s", "members/local/permissions.p7s"}) {
    const auto good = content_of(root_ / name);
    for (const auto* instead : {"governance.p7s", "revoked.p7s", "members/local/permissions.p7s"}) {
      if (std::string_view(name) == instead) continue;
      overwrite(root_ / name, content_of(root_ / instead));
      EXPECT_FALSE(read_all()) << instead << " as " << name;
      overwrite(root_ / name, good);
    }
  }
  EXPECT_TRUE(read_all());
}

TEST_F(TrustFolderTest, SymbolicLinksAreRefused) {
  for (const auto* name : {"identity-ca.pem", "governance.p7s", "ca/identity.key", "ca", "members", "members/local",
                           "members/local/key.pem", "members/local/certificate.pem"}) {
    const auto away = fs::path(folder_ / "moved");
    fs::rename(root_ / name, away);
    fs::create_symlink(away, root_ / name);
    const auto read = read_all();
    EXPECT_FALSE(read) << name;
    if (!read) {
      EXPECT_EQ(read.error().code, ErrorCode::kRefused) << read.error().text;
      EXPECT_NE(read.error().text.find("symbolic link"), std::string::npos) << read.error().text;
    }
    fs::remove(root_ / name);
    fs::rename(away, root_ / name);
  }
  EXPECT_TRUE(read_all());
}

TEST_F(TrustFolderTest, NothingIsWrittenThroughASymbolicLink) {
  const auto precious = folder_ / "precious";
  overwrite(precious, "mine");
  fs::remove(root_ / "revoked.p7s");
  fs::create_symlink(precious, root_ / "revoked.p7s");
  ASSERT_TRUE(trust_.write_revoked("text"));
  EXPECT_EQ(content_of(precious), "mine");
  EXPECT_FALSE(fs::is_symlink(root_ / "revoked.p7s"));
  fs::rename(root_ / "members", folder_ / "elsewhere");
  fs::create_symlink(folder_ / "elsewhere", root_ / "members");
  EXPECT_FALSE(trust_.write_key("local", *PrivateKey::make(), KeyReaders::kOwner));
}

TEST_F(TrustFolderTest, KeysThatOthersMayUseAreRefused) {
  for (const auto* name : {"ca/identity.key", "ca/permissions.key", "members/local/key.pem"}) {
    const auto good = mode_of(root_ / name);
    for (const mode_t mode : {0604U, 0602U, 0601U, 0620U, 0644U, 0666U}) {
      ASSERT_EQ(::chmod((root_ / name).c_str(), mode), 0);
      const auto read = trust_.files().read_key(name);
      ASSERT_FALSE(read) << name << " " << mode;
      EXPECT_EQ(read.error().code, ErrorCode::kRefused);
      EXPECT_NE(read.error().text.find("chmod 600"), std::string::npos) << read.error().text;
    }
    ASSERT_EQ(::chmod((root_ / name).c_str(), good), 0);
  }
}

TEST_F(TrustFolderTest, AGroupMayReadAKeyOnlyIfItIsThatOfThePeople) {
  const auto key = root_ / "members/local/key.pem";
  const auto other = people_group().value_or(::getegid()) + 1;
  if (::chown(key.c_str(), static_cast<uid_t>(-1), other) != 0) GTEST_SKIP() << "needs root";
  ASSERT_EQ(::chmod(key.c_str(), 0640), 0);
  EXPECT_FALSE(trust_.files().read_key("members/local/key.pem"));
  // systemd hands a key out with an access list, whose mask looks like the mode of the group.
  EXPECT_TRUE(read_credential(key));
  ASSERT_EQ(::chmod(key.c_str(), 0644), 0);
  EXPECT_FALSE(read_credential(key));
}

TEST_F(TrustFolderTest, PapersThatOthersMayChangeAreRefused) {
  ASSERT_EQ(::chmod((root_ / "identity-ca.pem").c_str(), 0666), 0);
  const auto read = read_all();
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().text.find("identity-ca.pem: others may change this file"), std::string::npos);
}

TEST_F(TrustFolderTest, KeysOfAuthoritiesAndIslandsAreForNoGroup) {
  const support::HostGroup people("rubicon");
  if (!people.exists()) GTEST_SKIP() << people.reason();
  ASSERT_EQ(people_group(), people.number());
  for (const auto* name : {"ca/identity.key", "members/local/key.pem"}) {
    const auto key = root_ / name;
    ASSERT_EQ(::chown(key.c_str(), static_cast<uid_t>(-1), people.number()), 0);
    ASSERT_EQ(::chmod(key.c_str(), 0640), 0);
    EXPECT_EQ(trust_.files().read_key(name, KeyReaders::kOwner).error().code, ErrorCode::kRefused) << name;
    EXPECT_TRUE(trust_.files().read_key(name, KeyReaders::kPeople)) << name;
  }
  EXPECT_EQ(Issuer::open(root_, kNow).error().code, ErrorCode::kRefused);
}

TEST_F(TrustFolderTest, ThePeopleOfTheHostReadTheKeyOfLocalOnly) {
  const support::HostGroup people("rubicon");
  if (!people.exists()) GTEST_SKIP() << people.reason();
  const auto root = fs::path(folder_ / "hall");
  ASSERT_TRUE(init(root, {"Rubicon", {OwnerId{7}}}, kNow));
  const auto access_of = [&root](const char* name) {
    struct stat about {};
    EXPECT_EQ(::stat((root / name).c_str(), &about), 0) << name;
    return std::pair(about.st_mode & 07777U, about.st_gid);
  };
  EXPECT_EQ(access_of("members/local/key.pem"), std::pair(0640U, people.number()));
  for (const auto* name : {"members/island-7/key.pem", "ca/identity.key", "ca/permissions.key", "ca/members"})
    EXPECT_EQ(access_of(name).first, 0600U) << name;
}

/// Whoever may read a key can act as its member.
TEST_F(TrustFolderTest, AKeyIsForThePeopleOfTheHostOnlyIfThatIsAskedFor) {
  const support::HostGroup people("rubicon");
  if (!people.exists()) GTEST_SKIP() << people.reason();
  const auto readers = [](const fs::path& root, const char* name) {
    return std::pair(FolderFiles(root).key_readers(key_file(name)), mode_of(root / key_file(name)));
  };
  const std::pair for_owner(KeyReaders::kOwner, mode_t{0600}), for_people(KeyReaders::kPeople, mode_t{0640});
  ASSERT_TRUE(add_here(root_, {"panel", {}, {}, 100}, kNow));
  EXPECT_EQ(readers(root_, "panel"), for_owner);
  ASSERT_TRUE(add_here(root_, {"people", {}, {}, 100}, kNow, KeyReaders::kPeople));
  EXPECT_EQ(readers(root_, "people"), for_people);
  const auto hall = add_here(root_, {"hall", OwnerId{8}, {}, 100}, kNow, KeyReaders::kPeople);
  ASSERT_FALSE(hall);
  EXPECT_EQ(hall.error().code, ErrorCode::kInvalid);
  EXPECT_FALSE(fs::exists(root_ / "members/hall"));

  const auto away = fs::path(folder_ / "away");
  const auto desk = add(root_, {"desk", {}, {}, 100}, kNow);
  ASSERT_TRUE(desk);
  ASSERT_TRUE(join(away, desk->bundle, desk->phrase.view(), kNow));
  EXPECT_EQ(readers(away, "desk"), for_owner);
  ASSERT_TRUE(join(away, desk->bundle, desk->phrase.view(), kNow, Older::kRefuse, KeyReaders::kPeople));
  EXPECT_EQ(readers(away, "desk"), for_people);
  const auto renewed = renew(root_, "desk", 200, kNow);
  ASSERT_TRUE(renewed && join(away, renewed->bundle, {}, kNow));
  EXPECT_EQ(readers(away, "desk"), for_people) << "as before";
  const auto island = add(root_, member_of_island(OwnerId{9}), kNow);
  ASSERT_TRUE(island);
  EXPECT_FALSE(join(away, island->bundle, island->phrase.view(), kNow, Older::kRefuse, KeyReaders::kPeople));
  EXPECT_FALSE(fs::exists(away / "members/island-9"));
}

TEST_F(TrustFolderTest, AFolderThatOthersMayChangeIsNotUsed) {
  const auto open = fs::path(folder_ / "open");
  fs::create_directory(open);
  ASSERT_EQ(::chmod(open.c_str(), 0777), 0);
  const auto made = init(open, {}, kNow);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().text, testing::HasSubstr("others may change this folder"));
  EXPECT_TRUE(fs::is_empty(open));
  ASSERT_EQ(::chmod(open.c_str(), 0755), 0);
  fs::create_directory(open / "ca");
  ASSERT_EQ(::chmod((open / "ca").c_str(), 0755), 0);
  ASSERT_TRUE(init(open, {}, kNow));
  EXPECT_EQ(mode_of(open / "ca"), 0700U) << "what was too wide is narrower";
  if (::geteuid() != 0) return;
  const auto foreign = fs::path(folder_ / "foreign");
  fs::create_directory(foreign);
  ASSERT_EQ(::chown(foreign.c_str(), 12345, 12345), 0);
  EXPECT_THAT(init(foreign, {}, kNow).error().text, testing::HasSubstr("belongs to another user"));
}

TEST_F(TrustFolderTest, APipeOrAFolderInPlaceOfAFileIsRefused) {
  fs::remove(root_ / "governance.p7s");
  ASSERT_EQ(::mkfifo((root_ / "governance.p7s").c_str(), 0644), 0);
  EXPECT_FALSE(read_all());
  fs::remove(root_ / "governance.p7s");
  fs::create_directory(root_ / "governance.p7s");
  EXPECT_FALSE(read_all());
}

TEST_F(TrustFolderTest, AMissingFileIsNamed) {
  for (const auto* name : {"permissions-ca.pem", "governance.p7s", "revoked.p7s", "ca/permissions.key", "ca/blocks",
                           "ca/members", "members/local/permissions.p7s", "members/local/key.pem"}) {
    fs::rename(root_ / name, folder_ / "moved");
    const auto read = read_all();
    ASSERT_FALSE(read) << name;
    EXPECT_NE(read.error().text.find(name), std::string::npos) << read.error().text;
    fs::rename(folder_ / "moved", root_ / name);
  }
}

TEST_F(TrustFolderTest, WhoMayReadTheFolderCannotHoldItsLock) {
  const auto reader = OwnFile::of_descriptor(::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ASSERT_EQ(::flock(reader.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_TRUE(trust_.files().lock(Duration(0)));
  EXPECT_TRUE(Issuer::open(root_, kNow));
  if (::geteuid() != 0) return;
  const auto child = ::fork();
  if (child == 0) {
    const bool denied = ::setuid(12345) == 0 && ::open((root_ / kLockFile).c_str(), O_RDONLY) < 0 && errno == EACCES;
    ::_exit(denied ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST_F(TrustFolderTest, TheLockIsForItsOwnerOnlyWhateverWasThere) {
  ASSERT_EQ(::chmod((root_ / kLockFile).c_str(), 0666), 0);
  EXPECT_TRUE(trust_.files().lock());
  EXPECT_EQ(mode_of(root_ / kLockFile), 0600U);
  fs::remove(root_ / kLockFile);
  EXPECT_TRUE(trust_.files().lock());
  EXPECT_EQ(mode_of(root_ / kLockFile), 0600U);
  fs::remove(root_ / kLockFile);
  fs::create_symlink(root_ / "revoked.p7s", root_ / kLockFile);
  EXPECT_EQ(trust_.files().lock().error().code, ErrorCode::kRefused);
  if (::geteuid() != 0) return;
  fs::remove(root_ / kLockFile);
  ASSERT_EQ(::chown(root_.c_str(), 12345, 12345), 0);
  EXPECT_TRUE(trust_.files().lock());
  struct stat about {};
  ASSERT_EQ(::stat((root_ / kLockFile).c_str(), &about), 0);
  EXPECT_EQ(about.st_uid, 12345U) << "of the user whose folder it is";
}

/// Root gives the lock of a folder to its owner, and nothing else.
TEST_F(TrustFolderTest, ALockThatIsALinkOrNoFileIsRefused) {
  const auto lock = root_ / kLockFile, precious = fs::path(folder_ / "precious");
  overwrite(precious, "of root");
  fs::remove(lock);
  fs::create_hard_link(precious, lock);
  ASSERT_TRUE(::geteuid() != 0 || ::chown(root_.c_str(), 12345, 12345) == 0);
  const auto linked = trust_.files().lock();
  ASSERT_FALSE(linked);
  EXPECT_THAT(linked.error().text, testing::HasSubstr(lock.string() + ": is no ordinary file with one name"));
  struct stat about {};
  ASSERT_EQ(::stat(precious.c_str(), &about), 0);
  EXPECT_EQ(about.st_uid, ::geteuid());
  EXPECT_NE(about.st_mode & 07777U, 0600U);
  fs::remove(lock);
  ASSERT_EQ(::mkfifo(lock.c_str(), 0600), 0);
  EXPECT_EQ(trust_.files().lock().error().code, ErrorCode::kRefused);
  fs::remove(lock);
  EXPECT_TRUE(trust_.files().lock());
  if (::geteuid() != 0) return;
  ASSERT_EQ(::chown(lock.c_str(), 54321, 54321), 0);
  EXPECT_THAT(trust_.files().lock().error().text, testing::HasSubstr("belongs to another user than its folder"));
}

TEST_F(TrustFolderTest, ALockIsWaitedForUntilALimit) {
  auto held = trust_.files().lock();
  ASSERT_TRUE(held);
  const auto busy = trust_.files().lock(std::chrono::milliseconds(100));
  ASSERT_FALSE(busy);
  EXPECT_EQ(busy.error().code, ErrorCode::kBusy);
  EXPECT_NE(busy.error().text.find((root_ / kLockFile).string()), std::string::npos) << busy.error().text;
  const auto child = ::fork();  // it has the lock too
  if (child == 0) {
    ::usleep(300'000);
    ::_exit(0);
  }
  held = fail(ErrorCode::kNotFound, "given back");
  EXPECT_TRUE(trust_.files().lock(std::chrono::minutes(1)));
  ::waitpid(child, nullptr, 0);
}

TEST_F(TrustFolderTest, NothingIsLeftBeside) {
  ASSERT_TRUE(revoke(root_, "island-7", kNow));
  for (const auto& entry : fs::recursive_directory_iterator(root_))
    EXPECT_FALSE(entry.path().filename().string().starts_with('.')) << entry.path();
}

}  // namespace
}  // namespace rubicon::trust
