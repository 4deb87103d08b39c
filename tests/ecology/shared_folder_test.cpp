#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>

#include "support/meeting_folder.h"
#include "support/people.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using support::Outcome;
using support::Process;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kTool = RUBICON_BINARY_DIR "/bin/rubicon";
constexpr const char* kCommand = "1:proxy.dummy-1.den.actuator.switch-1.command";
constexpr const char* kDenSwitch = "1:proxy.dummy-1.den.actuator.switch-1.value";
/// The service has the user and group `daemon`, whose group stands for `rubicon`.
constexpr unsigned kService = 1, kAnn = 65001, kBob = 65002;

/// The folder that the packages make, with an island of the service, and people with and without the group.
class SharedFolder : public testing::Test {
 protected:
  void SetUp() override {
    if (!support::share_folder(folder_.path(), kService, kService)) GTEST_SKIP() << "needs root of the host";
    if (as(kAnn, {kTool, "--version"}).code != 0) GTEST_SKIP() << "needs setpriv, and programs that all may run";
  }
  std::string place(const std::string& name) const { return (fs::path(folder_.path()) / name).string(); }
  static std::vector<std::string> of(unsigned user, std::vector<std::string> words, bool in_group = true) {
    return support::as_user(user, in_group ? kService : 0, std::move(words));
  }
  static Outcome as(unsigned user, std::vector<std::string> words, bool in_group = true) {
    return support::run_to_end(of(user, std::move(words), in_group));
  }
  std::string file(int id, const std::string& more = "") const {
    const auto path = (fs::path(files_.path()) / (std::to_string(id) + ".yaml")).string();
    std::ofstream(path) << "island: {id: " << id << ", name: home}\nnetworks:\n"
                        << "  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: {}}}}}\n"
                        << more;
    ::chmod(files_.path().c_str(), 0755);
    return path;
  }
  std::unique_ptr<Process> island(int id, const std::string& more = "") const {
    auto one = std::make_unique<Process>(
        of(kService, {support::kDaemon, "run", file(id, more), "--shell", "--log-level", "warning"}));
    one->write("stats\n");
    EXPECT_TRUE(one->line_with("\"ok\"")) << one->errors();
    return one;
  }

  support::MeetingFolder files_, folder_;  ///< the latter is RUBICON_FOLDER
};

TEST_F(SharedFolder, WhoeverHasTheGroupReachesTheIslandsAndNobodyElse) {
  const auto one = island(1), two = island(2);
  const auto listed = as(kAnn, {kTool, "islands"});
  EXPECT_EQ(listed.code, 0) << listed.errors;
  EXPECT_THAT(listed.output, AllOf(HasSubstr("\n1   "), HasSubstr("\n2   ")));
  EXPECT_EQ(as(kAnn, {kTool, "set", kCommand, "on"}).code, 0);
  EXPECT_EQ(as(kBob, {kTool, "get", kDenSwitch}).output, "on\n");
  EXPECT_EQ(support::run_to_end({kTool, "get", kDenSwitch}).output, "on\n") << "root";
  const auto stranger = as(kBob, {kTool, "get", kDenSwitch}, false);
  EXPECT_EQ(stranger.code, 1);
  EXPECT_THAT(stranger.errors, HasSubstr("Permission denied"));
  EXPECT_EQ(one->errors() + two->errors(), "");
}

TEST_F(SharedFolder, IslandsOfPeopleAreNotThoseOfTheService) {
  const auto own = as(kAnn, {support::kDaemon, "run", file(7)});
  EXPECT_EQ(own.code, 2);
  EXPECT_THAT(own.errors, HasSubstr("component 7: islands in " + folder_.path() +
                                    " run only as the service; for your own island "
                                    "set RUBICON_FOLDER to a folder of yours"));
}

TEST_F(SharedFolder, RulesKnowThePeopleByNumberGroupAndRoot) {
  const auto one = island(1,
                          "rights:\n  - {who: \"user:65001\", may: all}\n"
                          "  - {who: \"group:daemon\", may: read, keys: [\"proxy.**\"]}\n");
  EXPECT_EQ(as(kAnn, {kTool, "set", kCommand, "on"}).code, 0);
  EXPECT_EQ(as(kBob, {kTool, "get", kDenSwitch}).output, "on\n") << "of the group";
  const auto refused = as(kBob, {kTool, "set", kCommand, "off"});
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.output + refused.errors,
              HasSubstr("user:65002 may not set proxy.dummy-1.den.actuator.switch-1.command"));
  EXPECT_EQ(support::run_to_end({kTool, "set", kCommand, "off"}).code, 0) << "root";
  EXPECT_EQ(as(kAnn, {kTool, "get", kDenSwitch}).output, "off\n");
}

/// Nobody is root's guest, and root nobody's: in a folder of another user it would follow what that user puts there.
TEST_F(SharedFolder, RootMeetsInNoFolderOfAnotherUser) {
  const auto own = place("people/own");
  fs::create_directories(own);
  ASSERT_EQ(::chown(own.c_str(), kAnn, kAnn), 0);
  ASSERT_EQ(::chmod(own.c_str(), 0700), 0);
  const auto refused = support::run_to_end({kTool, "--folder", own, "islands"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("belongs to uid 65001"));
}

/// As in the unit of an island: systemd.exec(5), RestrictSUIDSGID=.
TEST_F(SharedFolder, TheServiceNeedsNoRightToSetTheGroupOfFolders) {
  const auto one = island(1);
  struct stat made {};
  ASSERT_EQ(::stat(place("islands/default").c_str(), &made), 0);
  EXPECT_EQ(made.st_mode & 07777, 02750U) << "from the folder above";
  EXPECT_EQ(made.st_gid, kService);
}

/// Loopback is not a folder: all users of the host reach it.
TEST_F(SharedFolder, ThePageOfAnIslandNeedsTokens) {
  Process one(of(kService, {support::kDaemon, "run", file(1, "web: {}\n"), "--shell", "--log-level", "warning"}));
  one.write("stats\nquit\n");
  EXPECT_EQ(one.exit_code(), 0);
  EXPECT_THAT(one.errors(), HasSubstr("where several users have the folder of the host, each caller needs a token"));
}

/// Nobody uses what another user made in their name.
TEST_F(SharedFolder, AFolderThatAnotherUserMadeIsRefused) {
  ASSERT_EQ(as(kBob, {"mkdir", place("people/") + std::to_string(kAnn)}).code, 0);
  const auto refused = as(kAnn, {kTool, "islands"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("belongs to uid 65002"));
  const auto removed = as(kAnn, {"rmdir", place("people/") + std::to_string(kAnn)});
  EXPECT_NE(removed.code, 0) << "nobody removes what another user made";
}

TEST_F(SharedFolder, AStoppedInstanceIsGoneAndAnEmptiedFolderIsMadeAgain) {
  auto one = island(1);
  const auto two = island(2);
  one->write("quit\n");
  EXPECT_EQ(one->exit_code(), 0);
  EXPECT_THAT(as(kAnn, {kTool, "islands"}).output, Not(HasSubstr("\n1   ")));
  fs::remove_all(place("islands/default"));
  Outcome found;
  for (int i = 0; i < 600 && found.output.find("\n2   ") == std::string::npos; ++i) {
    found = as(kAnn, {kTool, "islands"});
    ::usleep(100'000);
  }
  EXPECT_THAT(found.output, HasSubstr("\n2   "));
}

}  // namespace
}  // namespace rubicon::ecology
