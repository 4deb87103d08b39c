#include "rights/audit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/folder.h"

namespace rubicon::rights {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class AuditFileTest : public ::testing::Test {
 protected:
  AuditFile& audit() {
    if (!audit_) {
      auto opened = AuditFile::open(options, time, Log(log, "audit"), Log(requests, "audit"));
      EXPECT_TRUE(opened) << opened.error().text;
      audit_ = std::move(*opened);
    }
    return *audit_;
  }
  void accepted(std::string_view key, std::string_view value, const tuples::Member& who) {
    audit().write({who, OwnerId{70001}, "desk.lan", "set", key, value, true, ""});
  }
  void refused(const tuples::Member& who, int times = 1) {
    for (int i = 0; i < times; ++i)
      audit().write({who, OwnerId{70001}, "desk.lan", "set", "proxy.a", "on", false, "may not"});
  }
  std::vector<Json> lines(const AuditQuery& query = {}) {
    std::vector<Json> found;
    const auto read = read_audit(file, query, [&](std::string_view line) { found.push_back(Json::parse(line)); });
    EXPECT_TRUE(read) << read.error().text;
    return found;
  }
  std::vector<std::string> values() {
    time.run_ready();
    std::vector<std::string> texts;
    for (const auto& line : lines()) texts.push_back(line.value("value", "-"));
    return texts;
  }

  support::Folder folder;
  std::string file = folder / "audit.log";
  VirtualScheduler time;
  support::CollectingLog log, requests;
  AuditOptions options{file};
  std::unique_ptr<AuditFile> audit_;
  const tuples::Member robot{"robot", {"panel"}};
  const tuples::Member desk{"desk"};
};

TEST_F(AuditFileTest, ARequestIsALineThatSaysWhoAskedForWhatAndHowItEnded) {
  accepted("proxy.knx.1.actuator.switch-1.command", "on", robot);
  refused(desk);
  time.run_ready();
  const auto found = lines();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0]["who"], "robot");
  EXPECT_EQ(found[0]["id"], 70001);
  EXPECT_EQ(found[0]["host"], "desk.lan");
  EXPECT_EQ(found[0]["verb"], "set");
  EXPECT_EQ(found[0]["key"], "proxy.knx.1.actuator.switch-1.command");
  EXPECT_EQ(found[0]["value"], "on");
  EXPECT_EQ(found[0]["verdict"], "accepted");
  EXPECT_EQ(found[1]["verdict"], "refused");
  EXPECT_EQ(found[1]["why"], "may not");
  EXPECT_DOUBLE_EQ(found[1]["t"].get<double>(), base::to_seconds(time.wall_now()));
  EXPECT_TRUE(requests.contains("audit: robot set proxy.knx.1.actuator.switch-1.command: accepted"));
  EXPECT_TRUE(requests.contains("audit: desk set proxy.a: refused: may not"));
}

TEST_F(AuditFileTest, OnlyItsUserAndGroupMayReadIt) {
  accepted("proxy.a", "on", robot);
  time.run_ready();
  struct stat about {};
  ASSERT_EQ(::stat(file.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0137U, 0U);
}

TEST_F(AuditFileTest, ALinkInItsPlaceIsRefused) {
  std::ofstream(folder / "victim") << "precious";
  fs::create_symlink(folder / "victim", file);
  const auto opened = AuditFile::open(options, time, Log(log, "audit"), Log(requests, "audit"));
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().text, HasSubstr("is a symbolic link"));
}

TEST_F(AuditFileTest, AValueIsCutAfter64BytesAtACharacter) {
  accepted("proxy.a", std::string(63, 'x') + "\xc3\xa4 and more", robot);
  EXPECT_THAT(values(), ElementsAre(std::string(63, 'x')));
}

TEST_F(AuditFileTest, NoTextOfALineIsLongerThanItsLimit) {
  const std::string huge(1'000'000, 'x');
  tuples::Member who{huge};
  who.through = huge;
  for (int i = 0; i < 50; ++i) audit().write({who, OwnerId{70001}, huge, huge, huge, huge, false, huge, "refused"});
  time.run_ready();
  ASSERT_EQ(lines().size(), 50U);
  const auto line = lines().front();
  for (const auto* text : {"who", "through", "host", "verb", "key"})
    EXPECT_EQ(line[text].get<std::string>().size(), AuditFile::kTextBytes) << text;
  EXPECT_EQ(line["value"].get<std::string>().size(), AuditFile::kValueBytes);
  EXPECT_EQ(line["why"].get<std::string>().size(), AuditFile::kWhyBytes);
  for (const auto& one : requests.lines) EXPECT_LT(one.size(), 2000U);
}

TEST_F(AuditFileTest, SecretsAreNeverWritten) {
  options.hide = {"proxy.*.*.actuator.alarm-*.command"};
  accepted("proxy.a.b.actuator.alarm-1.command", "4711", robot);
  accepted("proxy.a.b.property.password-1.command", "4712", robot);
  accepted("proxy.a.b.property.text-1.command", "token=4713", robot);
  accepted("proxy.a.b.property.text-1.command", "http://anna:4714@host/", robot);
  EXPECT_THAT(values(), ElementsAre("-", "-", "token=****", "http://anna:****@host/"));
  EXPECT_EQ(lines()[0]["hidden"], true);
  EXPECT_FALSE(requests.contains("471"));
  EXPECT_TRUE(log.lines.empty()) << "others may read that log";
}

TEST_F(AuditFileTest, TextOfOthersCannotMakeALineOfItsOwn) {
  accepted("proxy.a", "on\"}\n{\"t\":1,\"who\":\"mallory\"}", robot);
  time.run_ready();
  ASSERT_EQ(lines().size(), 1U);
  EXPECT_EQ(lines()[0]["who"], "robot");
}

TEST_F(AuditFileTest, AFloodOfRefusalsIsCountedAndHidesNothing) {
  refused(desk, 5000);
  accepted("proxy.a", "on", robot);
  refused(robot);
  time.run_for(2s);
  const auto found = lines();
  ASSERT_EQ(found.size(), RefusalLimit::kPerSecond + 3);
  EXPECT_EQ(found[100]["verdict"], "accepted");
  EXPECT_EQ(found[101]["who"], "robot");
  EXPECT_EQ(found[102]["who"], "desk");
  EXPECT_EQ(found[102]["more"], 4900);
  EXPECT_EQ(audit().counters().refused, 5001U);
}

TEST_F(AuditFileTest, AFloodOfHoursDoesNotPushOutWhatWasAccepted) {
  options.size = 12'000'000;  // the usual size holds a day of it
  accepted("proxy.first", "on", robot);
  for (int i = 0; i < 3 * 120; ++i) {
    refused(desk, 110);
    time.run_for(30s);
  }
  EXPECT_EQ(lines().front()["key"], "proxy.first");
  EXPECT_LT(lines().size(), 3 * (RefusalLimit::kPerHour + 240));
}

TEST_F(AuditFileTest, NamesBeyondTheMostShareOneCount) {
  for (std::size_t i = 0; i < RefusalLimit::kMaxNameCount + 50; ++i) refused({fmt::format("name{}", i)}, 10);
  time.run_for(2s);
  const auto found = lines();
  EXPECT_EQ(found.size(), RefusalLimit::kMaxNameCount * 10 + RefusalLimit::kPerSecond + 1);
  EXPECT_EQ(found.back()["who"], RefusalLimit::kOthers);
  EXPECT_EQ(found.back()["more"], 400);
}

TEST_F(AuditFileTest, TheFilesTogetherKeepToTheirSize) {
  options.size = 50'000;
  for (int i = 0; i < 2000; ++i) {
    accepted("proxy.a", std::to_string(i), robot);
    time.run_ready();
  }
  std::uintmax_t bytes = 0;
  std::size_t files = 0;
  for (const auto& one : fs::directory_iterator(folder.path())) {
    bytes += one.file_size();
    ++files;
  }
  EXPECT_EQ(files, 5U);
  EXPECT_LE(bytes, options.size);
  const auto kept = values();
  ASSERT_GT(kept.size(), 100U);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], std::to_string(2000 - kept.size() + i));
}

TEST_F(AuditFileTest, ItGoesOnInANewFileAfterAnotherProgramRenamedIt) {
  accepted("proxy.a", "before", robot);
  time.run_ready();
  fs::rename(file, file + ".1");
  accepted("proxy.a", "between", robot);
  time.run_ready();
  audit().reopen();
  accepted("proxy.a", "after", robot);
  EXPECT_THAT(values(), ElementsAre("before", "between", "after"));
  EXPECT_TRUE(fs::exists(file));
}

TEST_F(AuditFileTest, ARestartAppends) {
  accepted("proxy.a", "before", robot);
  audit_.reset();
  accepted("proxy.a", "after", robot);
  EXPECT_THAT(values(), ElementsAre("before", "after"));
}

/// Writes beyond so many bytes of a file fail, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit less{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &less);
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(AuditFileTest, AFullDiskIsSaidOnceAndCountedAndTheAuditGoesOnAfterwards) {
  accepted("proxy.a", "before", robot);
  time.run_ready();
  {
    const FullDisk full(fs::file_size(file) + 30);
    for (int i = 0; i < 3; ++i) {
      accepted("proxy.a", "lost", robot);
      time.run_ready();
    }
  }
  EXPECT_EQ(audit().counters().lost, 3U);
  EXPECT_EQ(std::count_if(log.lines.begin(), log.lines.end(),
                          [](const auto& line) { return line.find("cannot write") != line.npos; }),
            1);
  accepted("proxy.a", "after", robot);
  EXPECT_THAT(values(), ElementsAre("before", "-", "after"));
  EXPECT_EQ(lines()[1]["lost"], 3);
  EXPECT_TRUE(log.contains("is written again; 3 lines were lost"));
}

TEST_F(AuditFileTest, TheLogGetsTheFirstLinesOfALongRunAndACount) {
  for (int i = 0; i < 80; ++i) accepted("proxy.a", "on", robot);
  time.run_for(11s);
  EXPECT_EQ(requests.lines.size(), RequestLog::kLines + 1);
  EXPECT_THAT(requests.lines.back(), HasSubstr("30 more accepted requests, which " + file + " names"));
  EXPECT_EQ(lines().size(), 80U);
}

TEST_F(AuditFileTest, RefusalsDoNotTakeTheRoomOfOthersInTheLog) {
  options.file.clear();  // the log is the only audit
  refused(desk, 90);
  accepted("proxy.lamp", "on", robot);
  EXPECT_TRUE(requests.contains("robot set proxy.lamp: accepted"));
  time.run_for(11s);
  EXPECT_EQ(requests.lines.size(), RequestLog::kLines + 2);
}

TEST_F(AuditFileTest, AReasonThatQuotesAHiddenValueIsNotWritten) {
  options.hide = {"proxy.hidden"};
  for (const auto* key : {"proxy.hidden", "proxy.a.b.property.password-1.command"})
    audit().write({robot, OwnerId{70001}, "", "set", key, "4711", false, "expected a number, got 4711", "invalid"});
  audit().write({robot, OwnerId{70001}, "", "set", "proxy.a", "x", false, "got http://anna:4714@host/", "invalid"});
  time.run_ready();
  std::vector<std::string> whys;
  for (const auto& line : lines()) whys.push_back(line["why"]);
  EXPECT_THAT(whys, ElementsAre("invalid", "invalid", "got http://anna:****@host/"));
  EXPECT_FALSE(requests.contains("471"));
}

TEST_F(AuditFileTest, TheLogHasNoReasonThatQuotesAValue) {
  audit().write(
      {robot, OwnerId{70001}, "", "set", "proxy.a", "4711", false, "expected a number, got 4711", "invalid", true});
  time.run_ready();
  EXPECT_EQ(lines()[0]["why"], "expected a number, got 4711");
  EXPECT_TRUE(requests.contains("audit: robot set proxy.a: refused: invalid"));
  EXPECT_FALSE(requests.contains("471"));
}

TEST_F(AuditFileTest, AnIslandThatNamesManySendersHasTheLimitOfOneMember) {
  for (int i = 0; i < 500; ++i) {
    tuples::Member claimed{fmt::format("name{}", i)};
    claimed.through = "island-2";
    refused(claimed);
  }
  time.run_for(2s);
  const auto found = lines();
  ASSERT_EQ(found.size(), RefusalLimit::kPerSecond + 1);
  EXPECT_EQ(found[0]["who"], "name0");
  EXPECT_EQ(found[0]["through"], "island-2");
  EXPECT_EQ(found.back()["who"], "island-2");
}

TEST_F(AuditFileTest, AllNamesTogetherHaveALimitPerHour) {
  for (int i = 0; i < 200; ++i) refused({fmt::format("name{}", i)}, 100);
  time.run_for(2s);
  EXPECT_EQ(lines({.refused_only = true}).size(), RefusalLimit::kAllPerHour);
}

/// No file can be opened.
class NoDescriptors {
 public:
  NoDescriptors() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit none{0, before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(AuditFileTest, WhereNoNewFileCanBeMadeTheOlderOnesStay) {
  options.size = 50'000;
  int count = 0;
  const auto fill = [&](int times) {
    for (int i = 0; i < times; ++i) {
      accepted("proxy.a", std::to_string(count++), robot);
      time.run_ready();
    }
  };
  fill(250);
  const auto before = values();
  {
    const NoDescriptors none;
    fill(100);
  }
  const auto after = values();
  ASSERT_EQ(after.size(), before.size() + 100);
  EXPECT_EQ(after.front(), before.front());
  EXPECT_EQ(log.lines.size(), 1U) << "said once";
  {
    const NoDescriptors none;
    fill(400);
  }
  EXPECT_GT(audit().counters().lost, 0U) << "it does not grow without bound";
  EXPECT_EQ(values().front(), before.front());
  fill(1);
  EXPECT_EQ(values().back(), std::to_string(count - 1));
}

TEST_F(AuditFileTest, APlaceWhereFilesCannotBeRenamedIsRefused) {
  fs::create_directories(folder / "audit.log.new/in-the-way");
  const auto opened = AuditFile::open(options, time, Log(log, "audit"), Log(requests, "audit"));
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().text, HasSubstr("cannot be renamed"));
}

TEST_F(AuditFileTest, AFileThatACrashLeftUnderItsOtherNameIsFound) {
  accepted("proxy.a", "before", robot);
  audit_.reset();
  fs::rename(file, file + ".new");
  accepted("proxy.a", "after", robot);
  EXPECT_THAT(values(), ElementsAre("before", "after"));
}

TEST_F(AuditFileTest, AReaderAsksByNameTimeAndVerdict) {
  accepted("proxy.a", "1", robot);
  time.run_for(1min);
  const auto middle = time.wall_now();
  accepted("proxy.a", "2", robot);
  refused(desk);
  time.run_ready();
  EXPECT_EQ(lines({.who = "robot"}).size(), 2U);
  EXPECT_EQ(lines({.from = middle}).size(), 2U);
  EXPECT_EQ(lines({.to = middle}).size(), 1U);
  EXPECT_EQ(lines({.refused_only = true}).size(), 1U);
}

TEST_F(AuditFileTest, AReaderCountsLinesThatAreNone) {
  accepted("proxy.a", "1", robot);
  time.run_ready();
  std::ofstream(file, std::ios::app) << "half a li\n{\"no\":1}\n";
  std::size_t found = 0;
  const auto whole = fs::file_size(file);
  std::ofstream(file, std::ios::app) << "{\"t\":";
  const auto read = read_audit(file, {}, [&](std::string_view) { ++found; });
  EXPECT_EQ(read->damaged, 3U);
  EXPECT_EQ(read->end, whole) << "the last line is still to come";
  EXPECT_EQ(found, 1U);
  EXPECT_EQ(read_audit(folder / "none", {}, [](std::string_view) {}).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace rubicon::rights
