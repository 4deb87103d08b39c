#include "state/state_file.h"

#include <gmock/gmock.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <random>

#include "state/child.h"
#include "state/state_support.h"

#define CHILD_CHECK(condition) \
  if (!holds(static_cast<bool>(condition), #condition)) return 1

namespace rubicon::state {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::MatchesRegex;

Error error_of(const std::string& path, IslandId island = kIsland) {
  const auto store = StateStore::open(path, island);
  if (store) return {ErrorCode::kInvalid, "it opened"};
  return store.error();
}

void fill(StateStore& store, int devices) {
  for (int i = 0; i < devices; ++i) {
    auto device = device_of("wsn-1", std::to_string(i));
    device.values = {value_at(sensor(1), double(i), i), value_at(sensor(2), std::string("on"), i)};
    ASSERT_TRUE(store.save(device));
  }
}

void run_sql(const std::string& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  char* why = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &why), SQLITE_OK) << why;
  sqlite3_free(why);
  sqlite3_close(database);
}

TEST(StateFile, OfAnotherIslandIsRefused) {
  Folder folder;
  opened(folder / "s").reset();
  const auto error = error_of(folder / "s", IslandId(7));
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.text, HasSubstr(folder / "s"));
  EXPECT_THAT(error.text, HasSubstr("of island 6541, expected island 7"));
}

TEST(StateFile, OfANewerVersionIsRefusedAndLeftAsItIs) {
  Folder folder;
  opened(folder / "s").reset();
  run_sql(folder / "s", fmt::format("PRAGMA user_version={}", schema_steps().size() + 1));
  const auto before = read_all(folder / "s");
  const auto error = error_of(folder / "s");
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.text, HasSubstr("newer"));
  EXPECT_EQ(read_all(folder / "s"), before);
}

TEST(StateFile, ThatIsNoneIsInvalidOrRefusedAndLeftAsItIs) {
  Folder folder;
  for (const std::string& content : {std::string("island: {id: 6541}\n"), std::string(100000, 'x'),
                                     std::string(4096, '\0'), std::string("SQLite format 3\0", 16)}) {
    write_all(folder / "s", content);
    EXPECT_EQ(error_of(folder / "s").code, ErrorCode::kInvalid) << content.size();
    EXPECT_EQ(read_all(folder / "s"), content);
  }
  run_sql(folder / "other", "CREATE TABLE device(row INTEGER)");
  const auto error = error_of(folder / "other");
  EXPECT_EQ(error.code, ErrorCode::kRefused);
  EXPECT_THAT(error.text, HasSubstr("another program"));
  EXPECT_EQ(error_of(folder.path()).code, ErrorCode::kInvalid);
  EXPECT_EQ(error_of(folder / "none/s").code, ErrorCode::kIo);
}

TEST(StateFile, ThatIsEmptyBecomesAFreshOne) {
  Folder folder;
  write_all(folder / "s", "");
  EXPECT_TRUE(opened(folder / "s")->save(device_of("wsn-1", "7")));
}

TEST(StateFile, WithAStrangeNameIsAFileLikeAnyOther) {
  Folder folder;
  const auto path = folder / "a b%41?mode=ro#x";
  EXPECT_TRUE(opened(path)->save(device_of("wsn-1", "7")));
  EXPECT_TRUE(fs::exists(path));
  EXPECT_EQ(opened(path)->stats().devices, 1U);
}

TEST(StateFile, TruncatedAnywhereIsNeverTakenForAnotherContent) {
  Folder folder;
  fill(*opened(folder / "whole"), 60);
  const auto whole = read_all(folder / "whole");
  ASSERT_GT(whole.size(), 10U * 4096);
  std::size_t damaged = 0;
  for (std::size_t size = 1; size < whole.size(); size += size < 200 ? 13 : 1021) {
    write_all(folder / "s", whole.substr(0, size));
    const auto store = StateStore::open(folder / "s", kIsland);
    if (!store) {
      EXPECT_EQ(store.error().code, ErrorCode::kInvalid) << size << ": " << store.error().text;
      ++damaged;
    }
    EXPECT_FALSE(store) << size;
  }
  EXPECT_GT(damaged, 30U);
}

TEST(StateFile, WithFlippedBitsIsReadSkippedOrRefusedButNeverEndsTheProcess) {
  Folder folder;
  fill(*opened(folder / "whole"), 40);
  const auto whole = read_all(folder / "whole");
  std::mt19937 random(7);
  std::size_t refused = 0, skipped = 0;
  for (int round = 0; round < 400; ++round) {
    auto content = whole;
    for (int flips = 1 + round % 4; flips > 0; --flips) {
      // Half of them in the first pages, where the structure stands.
      const auto at = random() % (flips % 2 == 0 ? 8192 : content.size());
      content[at] = static_cast<char>(content[at] ^ (1 << random() % 8));
    }
    write_all(folder / "s", content);
    fs::remove(folder / "s-wal");
    const auto store = StateStore::open(folder / "s", kIsland);
    if (!store) {
      const auto code = store.error().code;
      EXPECT_TRUE(code == ErrorCode::kInvalid || code == ErrorCode::kRefused) << store.error().text;
      ++refused;
      continue;
    }
    const auto read = (*store)->each("", [](StateStore::Row, KnownDevice&&) {});
    EXPECT_TRUE(read || read.error().code == ErrorCode::kInvalid) << read.error().text;
    skipped += (*store)->stats().damaged > 0;
    std::ignore = (*store)->save(device_of("wsn-1", "7"));
    std::ignore = (*store)->forget("wsn-1", "3");
  }
  EXPECT_GT(refused, 20U);
  EXPECT_GT(skipped, 5U);
}

TEST(StateFile, WithRowsThatCannotBeReadGivesTheOthers) {
  Folder folder;
  fill(*opened(folder / "s"), 5);
  run_sql(folder / "s",
          "UPDATE announcement SET capabilities=x'ff' WHERE device=1; DELETE FROM announcement WHERE device=2;"
          "UPDATE device SET decision=9 WHERE row=3; UPDATE value SET form=4 WHERE device=4 AND type=1;"
          "UPDATE announcement SET point_ids=capabilities WHERE device=5");
  const auto store = opened(folder / "s");
  std::vector<std::string> seen;
  ASSERT_TRUE(store->each("", [&](StateStore::Row, KnownDevice&& device) {
    seen.push_back(device.address);
    EXPECT_EQ(device.values.size(), 1U);
  }));
  EXPECT_EQ(seen, std::vector<std::string>{"3"});
  EXPECT_EQ(store->stats().damaged, 5U);
  // The next announcement mends a device.
  ASSERT_TRUE(store->save(device_of("wsn-1", "0")));
  EXPECT_TRUE(*store->find("wsn-1", "0"));
}

TEST(StateFile, IsWrittenByOneAndReadByOthersMeanwhile) {
  Folder folder;
  auto writer = opened(folder / "s");
  ASSERT_TRUE(writer->save(device_of("wsn-1", "1")));
  const auto busy = error_of(folder / "s");
  EXPECT_EQ(busy.code, ErrorCode::kBusy);
  EXPECT_THAT(busy.text, HasSubstr(folder / "s"));
  fs::create_symlink(folder / "s", folder / "link");
  EXPECT_EQ(run_child([&] { return error_of(folder / "s").code == ErrorCode::kBusy ? 0 : 1; }), 0);

  const auto reader = StateStore::open_existing(folder / "s", StateStore::Use::kRead);
  ASSERT_TRUE(reader) << reader.error().text;
  EXPECT_EQ((*reader)->island(), kIsland);
  EXPECT_TRUE((*reader)->stats().read_only);
  ASSERT_TRUE(writer->begin());
  ASSERT_TRUE(writer->save(device_of("wsn-1", "2")));
  EXPECT_EQ(snapshot(**reader), text_of(device_of("wsn-1", "1")) + "\n");
  ASSERT_TRUE(writer->commit(true));
  EXPECT_EQ(snapshot(**reader), snapshot(*writer));
  EXPECT_EQ((*reader)->save(device_of("wsn-1", "3")).error().code, ErrorCode::kRefused);
  EXPECT_EQ((*reader)->begin().error().code, ErrorCode::kRefused);
  EXPECT_TRUE(writer->tidy());
  writer.reset();
  EXPECT_TRUE(opened(folder / "s")->save(device_of("wsn-1", "3")));
}

TEST(StateFile, AndAllBesideItIsReadByTheGroupAtMost) {
  Folder folder;
  const auto umask_before = ::umask(0);
  const auto store = opened(folder / "s");
  ASSERT_TRUE(store->save(device_of("wsn-1", "1")));
  for (const auto* suffix : {"", "-wal", "-shm", "-lock"})
    EXPECT_EQ(fs::status(folder / "s" + suffix).permissions(), fs::perms(0640)) << suffix;
  ::umask(umask_before);
}

TEST(StateFile, OfAnEarlierReleaseAndAllBesideItAreClosedToOthers) {
  Folder folder;
  {
    // What is left of one that died: with the log.
    const auto store = opened(folder / "s");
    fill(*store, 3);
    for (const auto* suffix : {"", "-wal", "-shm", "-lock"}) {
      fs::copy_file(folder / "s" + suffix, folder / "old" + suffix);
      fs::permissions(folder / "old" + suffix, fs::perms(0644));
    }
  }
  const auto store = opened(folder / "old");
  for (const auto* suffix : {"", "-wal", "-shm", "-lock"})
    EXPECT_EQ(fs::status(folder / "old" + suffix).permissions(), fs::perms(0640)) << suffix;
}

TEST(StateFile, ThatIsThereIsNotOnlyReadBecauseItsLockIsASymbolicLink) {
  Folder folder;
  opened(folder / "s").reset();
  fs::remove(folder / "s-lock");
  fs::create_symlink("elsewhere", folder / "s-lock");
  const auto error = error_of(folder / "s");
  EXPECT_EQ(error.code, ErrorCode::kIo);
  EXPECT_THAT(error.text, HasSubstr(folder / "s-lock: is a symbolic link"));
  EXPECT_FALSE(fs::exists(folder / "elsewhere"));
}

TEST(StateFile, IsNoSymbolicLinkNorIsItsLock) {
  Folder folder;
  fs::create_symlink("elsewhere", folder / "link");
  EXPECT_EQ(error_of(folder / "link").code, ErrorCode::kRefused);
  EXPECT_THAT(error_of(folder / "link").text, HasSubstr(folder / "link: is a symbolic link"));
  EXPECT_FALSE(fs::exists(folder / "elsewhere"));
  fs::create_symlink("elsewhere", folder / "s-lock");
  EXPECT_THAT(error_of(folder / "s").text, HasSubstr(folder / "s-lock: is a symbolic link"));
  EXPECT_FALSE(fs::exists(folder / "elsewhere"));
  fs::create_directory(folder / "real");
  fs::create_directory_symlink("real", folder / "folder");
  EXPECT_TRUE(opened(folder / "folder/s")) << "a folder may be one: who put it there owns what is above it";
}

TEST(StateFile, IsOpenedForToolsOnlyIfThereIsOne) {
  Folder folder;
  for (const auto use : {StateStore::Use::kRead, StateStore::Use::kWrite}) {
    const auto store = StateStore::open_existing(folder / "s", use);
    ASSERT_FALSE(store);
    EXPECT_EQ(store.error().code, ErrorCode::kNotFound);
    EXPECT_FALSE(fs::exists(folder / "s"));
  }
  opened(folder / "s").reset();
  const auto store = StateStore::open_existing(folder / "s", StateStore::Use::kWrite);
  ASSERT_TRUE(store);
  EXPECT_TRUE((*store)->save(device_of("wsn-1", "3")));
}

/// In a child process, as a user without permission to write the files of this one.
int as_nobody(const std::function<int()>& body) {
  return run_child([&] {
    if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) return 2;
    return body();
  });
}

int reads_but_does_not_write(const std::string& path, const std::string& expected) {
  return as_nobody([&] {
    const auto store = StateStore::open(path, kIsland);
    if (!store) std::fprintf(stderr, "%s\n", store.error().text.c_str());
    CHILD_CHECK(store);
    CHILD_CHECK((*store)->stats().read_only);
    CHILD_CHECK(snapshot(**store) == expected);
    CHILD_CHECK((*store)->save(device_of("x", "1")).error().code == ErrorCode::kRefused);
    CHILD_CHECK((*store)->forget("wsn-1", "1").error().code == ErrorCode::kRefused);
    CHILD_CHECK((*store)->begin().error().code == ErrorCode::kRefused);
    CHILD_CHECK((*store)->tidy());
    return 0;
  });
}

TEST(StateFile, ThatMayOnlyBeReadIsOpenedSo) {
  Folder folder;
  fill(*opened(folder / "s"), 3);
  const auto expected = snapshot(*opened(folder / "s"));
  ::chmod((folder / "s").c_str(), 0444);
  ::chmod(folder.path().c_str(), 0555);
  EXPECT_EQ(reads_but_does_not_write(folder / "s", expected), 0) << "file and folder";
  ::chmod((folder / "s").c_str(), 0666);
  EXPECT_EQ(reads_but_does_not_write(folder / "s", expected), 0) << "folder only";
  ::chmod((folder / "s").c_str(), 0444);
  ::chmod(folder.path().c_str(), 0777);
  EXPECT_EQ(reads_but_does_not_write(folder / "s", expected), 0) << "file only";
}

TEST(StateFile, ThatMayOnlyBeReadShowsWhatAProcessThatDiedHadCommitted) {
  Folder folder;
  EXPECT_EQ(run_child([&] {
              fill(*opened(folder / "s"), 3);
              const auto store = opened(folder / "s");
              CHILD_CHECK(store->save(device_of("wsn-1", "last")));
              ::_exit(0);  // without closing
            }),
            0);
  ASSERT_GT(fs::file_size(folder / "s-wal"), 0U);
  for (const auto* suffix : {"", "-wal", "-shm", "-lock"}) ::chmod((folder / "s" + suffix).c_str(), 0444);
  ::chmod(folder.path().c_str(), 0555);
  EXPECT_EQ(as_nobody([&] {
              const auto store = StateStore::open(folder / "s", kIsland);
              if (!store) std::fprintf(stderr, "%s\n", store.error().text.c_str());
              CHILD_CHECK(store);
              CHILD_CHECK((*store)->find("wsn-1", "last")->has_value());
              return 0;
            }),
            0);
  ::chmod(folder.path().c_str(), 0755);
  for (const auto* suffix : {"", "-wal", "-shm", "-lock"}) ::chmod((folder / "s" + suffix).c_str(), 0644);
}

/// Writes until the disk is full, then continues after `relief`.
int outlives_a_full_disk(const std::string& path, const std::function<void()>& relief) {
  const auto store = StateStore::open(path, kIsland);
  CHILD_CHECK(store);
  std::string before;
  Result<StateStore::Row> saved = StateStore::Row{0};
  for (int i = 0; i < 10000 && saved; ++i) {
    before = snapshot(**store);
    if (!(*store)->begin()) return 1;
    for (int k = 0; k < 20 && saved; ++k) {
      auto device = device_of("wsn-1", std::to_string(i * 20 + k));
      device.values = {value_at(sensor(1), std::string(200, 'x'), i)};
      saved = (*store)->save(device);
    }
    const auto committed = (*store)->commit(true);
    if (!committed && saved) saved = fail(committed.error());
    CHILD_CHECK(saved.has_value() == committed.has_value());
  }
  CHILD_CHECK(!saved);
  std::fprintf(stderr, "%s\n", saved.error().text.c_str());
  CHILD_CHECK(saved.error().code == ErrorCode::kIo);
  CHILD_CHECK(saved.error().text.find(path) != std::string::npos);
  CHILD_CHECK(snapshot(**store) == before);
  relief();
  CHILD_CHECK((*store)->begin());
  CHILD_CHECK((*store)->save(device_of("after", "1")));
  CHILD_CHECK((*store)->commit(true));
  CHILD_CHECK((*store)->find("after", "1")->has_value());
  return 0;
}

TEST(StateFile, OnADiskThatIsFullFailsToWriteAndGoesOnWhenThereIsRoom) {
  Folder folder;
  const auto mount_point = folder / "small";
  fs::create_directory(mount_point);
  constexpr int kNotPermitted = 3;
  const auto code = run_child([&] {
    if (::unshare(CLONE_NEWNS) != 0) return kNotPermitted;
    if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return kNotPermitted;
    if (::mount("none", mount_point.c_str(), "tmpfs", 0, "size=600k") != 0) return kNotPermitted;
    write_all(mount_point + "/ballast", std::string(100 << 10, 'b'));
    return outlives_a_full_disk(mount_point + "/s", [&] { fs::remove(mount_point + "/ballast"); });
  });
  if (code == kNotPermitted) GTEST_SKIP() << "may not mount a small file system here";
  EXPECT_EQ(code, 0);
}

TEST(StateFile, BeyondTheLargestFileOfItsUserFailsToWriteAndGoesOnWhenThereIsRoom) {
  Folder folder;
  EXPECT_EQ(run_child([&] {
              std::signal(SIGXFSZ, SIG_IGN);
              rlimit bound{300 << 10, RLIM_INFINITY};
              CHILD_CHECK(::setrlimit(RLIMIT_FSIZE, &bound) == 0);
              return outlives_a_full_disk(folder / "s", [] {
                rlimit none{RLIM_INFINITY, RLIM_INFINITY};
                ::setrlimit(RLIMIT_FSIZE, &none);
              });
            }),
            0);
}

TEST(StateFile, ThatIsDamagedIsSetAsideForANewOne) {
  Folder folder;
  for (int round = 0; round < 2; ++round) {
    write_all(folder / "s", std::string(5000, 'x'));
    write_all(folder / "s-wal", "old");
    ASSERT_EQ(error_of(folder / "s").code, ErrorCode::kInvalid);
    const auto moved = set_aside(folder / "s", at(0));
    ASSERT_TRUE(moved) << moved.error().text;
    EXPECT_THAT(*moved, MatchesRegex(".*/s.damaged-20260921T[0-9]{6}Z(-2)?"));
    EXPECT_EQ(read_all(*moved), std::string(5000, 'x'));
    EXPECT_FALSE(fs::exists(folder / "s-wal"));
    ASSERT_TRUE(opened(folder / "s")->save(device_of("wsn-1", "1")));
  }
  EXPECT_EQ(set_aside(folder / "none", at(0)).error().code, ErrorCode::kNotFound);
  const auto owner = opened(folder / "s");
  EXPECT_EQ(set_aside(folder / "s", at(0)).error().code, ErrorCode::kBusy);
  EXPECT_TRUE(owner->save(device_of("wsn-1", "2")));
}

TEST(StateFile, OfAnOlderVersionIsBroughtUpStepByStep) {
  Folder folder;
  fill(*opened(folder / "s"), 3);
  std::vector<const char*> steps(schema_steps().begin(), schema_steps().end());
  const auto newest = static_cast<std::int64_t>(steps.size());
  steps.push_back("ALTER TABLE device ADD COLUMN room TEXT NOT NULL DEFAULT 'hall'");
  steps.push_back("UPDATE device SET room='attic' WHERE row=2");
  auto database = *Database::open("state file", folder / "s", Database::Mode::kWrite);
  const auto header = read_header(database, steps);
  ASSERT_TRUE(header) << header.error().text;
  EXPECT_EQ(header->version, newest);
  ASSERT_TRUE(upgrade(database, header->version, steps));
  EXPECT_EQ(*database.number("PRAGMA user_version", "test"), newest + 2);
  EXPECT_EQ(*database.word("SELECT group_concat(room) FROM device", "test"), "hall,attic,hall");
  EXPECT_EQ(read_header(database, schema_steps()).error().code, ErrorCode::kRefused);
}

TEST(StateFile, OfTheFirstVersionIsReadAndTakesNames) {
  Folder folder;
  fill(*opened(folder / "s"), 3);
  run_sql(folder / "s",
          "ALTER TABLE device DROP COLUMN given_name; ALTER TABLE device DROP COLUMN area; DROP TABLE memory; "
          "PRAGMA user_version=1");
  const auto store = opened(folder / "s");
  EXPECT_EQ(store->stats().devices, 3u);
  ASSERT_TRUE(store->rename(2, "Kitchen mote", "Kitchen"));
  const auto device = *store->find("wsn-1", "1");
  ASSERT_TRUE(device);
  EXPECT_EQ(device->join.name, "Mote 1");
  EXPECT_EQ(device->values.size(), 2u);
  EXPECT_EQ(device->given_name, "Kitchen mote");
  EXPECT_EQ(device->area, "Kitchen");
}

TEST(StateFile, WhoseStepFailsStaysAtTheVersionBefore) {
  Folder folder;
  opened(folder / "s").reset();
  std::vector<const char*> steps(schema_steps().begin(), schema_steps().end());
  const auto newest = static_cast<std::int64_t>(steps.size());
  steps.insert(steps.end(), 2, "CREATE TABLE room(name TEXT)");
  auto database = *Database::open("state file", folder / "s", Database::Mode::kWrite);
  EXPECT_FALSE(upgrade(database, newest, steps));
  EXPECT_EQ(*database.number("PRAGMA user_version", "test"), newest + 1);
  EXPECT_FALSE(database.in_transaction());
}

}  // namespace
}  // namespace rubicon::state
