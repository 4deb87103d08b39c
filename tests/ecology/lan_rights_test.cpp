#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ecology/island_on_a_lan.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kMayRead = "  - {who: lan, may: [read, demand], keys: [\"proxy.**\"]}\n";
constexpr const char* kMayNotReadTheLamp =
    "  - {who: lan, may: [read, demand], keys: [\"proxy.**\"], not: [\"proxy.*.*.actuator.switch-1.**\"]}\n";

std::string part_of(const char* actuator, const char* part) {
  return std::string(actuator) + part;
}

/// An island with rights for whoever comes by DDS, and an audit.
class RightsOfTheLan : public IslandOnALan {
 protected:
  void give(const std::string& rules, const std::string& audit = "home.audit") const {
    configure("{interfaces: [cable], lease: 500ms}",
              "audit: {file: " + audit + "}\nrights:\n" + rules +
                  "  - {who: lan, may: set, keys: [\"proxy.*.*.actuator.switch-1.command\"]}\n"
                  "  - {who: everybody, may: all}\n  - {who: \"island:2\", may: all}\n");
  }
  /// `WHO VALUE VERDICT` of each line of a file, in order.
  static std::vector<std::string> requests_in(const std::string& path) {
    std::vector<std::string> all;
    std::ifstream lines(path);
    for (std::string text; std::getline(lines, text);) {
      if (text.find_first_not_of(' ') == text.npos) continue;
      const auto line = json::parse(text, nullptr, false);
      if (line.contains("lost")) {
        all.push_back("lost " + std::to_string(line["lost"].get<int>()));
        continue;
      }
      EXPECT_EQ(line.value("verb", ""), "set") << text;
      all.push_back(line.value("who", "") + " " + line.value("value", "") + " " + line.value("verdict", ""));
    }
    return all;
  }
  /// Up to the last byte of the file system, and of the last block of the audit.
  static void fill(const std::string& folder) {
    const auto audit = folder + "/home.audit";
    std::ofstream(audit, std::ios::app) << std::string(4095 - fs::file_size(audit) % 4096, ' ') << '\n';
    std::ofstream filler(folder + "/filler");
    while (filler << std::string(4096, 'x') << std::flush) continue;
  }
  void sets(const std::string& value) const {
    const auto done = other({"set", part_of(kLamp, "command"), value});
    EXPECT_EQ(done.code, 0) << done.errors << island_->errors();
  }
  void is_refused(const std::string& value) const {
    const auto refused = other({"set", part_of(kLock, "command"), value});
    EXPECT_EQ(refused.code, 3) << refused.errors << island_->errors();
    EXPECT_THAT(refused.output, HasSubstr("lan may not set proxy.dummy-1.den.actuator.switch-2.command"));
  }
};

TEST_F(RightsOfTheLan, SayWhatSomebodyOnAnotherHostMayAndEachRequestIsALine) {
  give(kMayRead);
  start_island();
  EXPECT_THAT(island_->errors(), HasSubstr("rights decide; all that come by DDS are the member lan"));
  for (const auto* value : {"on", "off"}) {
    sets(value);
    is_refused(value);
  }
  EXPECT_THAT(requests_in(file("home.audit")),
              ElementsAre("lan on accepted", "lan on refused", "lan off accepted", "lan off refused"));
  EXPECT_EQ(other({"get", part_of(kLamp, "value")}).output, "off\n");
  EXPECT_THAT(island_->errors(), HasSubstr("actuator.switch-1 = 'on' by")) << "the user of the island sees it";
  const auto log = other({"log"});
  EXPECT_THAT(log.output, HasSubstr("is up")) << log.errors;
  EXPECT_THAT(log.output, Not(HasSubstr("switch-1"))) << "others do not";
  const auto doctor = other({"doctor", "--for", "100ms"});
  EXPECT_THAT(doctor.output, HasSubstr("are the member `lan`; its rights say what `lan` may do"));
}

TEST_F(RightsOfTheLan, AReloadTakesATupleFromASubscriberAndGivesItBack) {
  give(kMayRead);
  start_island();
  sets("on");
  const auto watching =
      start(1, {kToolProgram, "watch", part_of(kLamp, "value"), "--json", "--engine", "dds", "--interfaces", "cable"});
  ASSERT_TRUE(watching->line_with(R"("value":"on")")) << watching->errors() << island_->errors();
  give(kMayNotReadTheLamp);
  island_->signal(SIGHUP);
  EXPECT_TRUE(watching->line_with(R"("event":"deleted")")) << watching->errors() << island_->errors();
  EXPECT_NE(other({"get", part_of(kLamp, "value")}).code, 0);
  give(kMayRead);
  island_->signal(SIGHUP);
  EXPECT_TRUE(watching->line_with(R"("value":"on")")) << watching->errors() << island_->errors();
}

TEST_F(RightsOfTheLan, TheAuditGoesOnInANewFileAfterLogrotateRenamedIt) {
  give(kMayRead);
  start_island();
  sets("on");
  fs::rename(file("home.audit"), file("home.audit-20260101"));
  sets("off");
  island_->signal(SIGHUP);
  ASSERT_TRUE(says(*island_, "reloaded " + file("home.yaml"))) << island_->errors();
  sets("on");
  EXPECT_THAT(requests_in(file("home.audit-20260101")), ElementsAre("lan on accepted", "lan off accepted"));
  EXPECT_THAT(requests_in(file("home.audit")), ElementsAre("lan on accepted"));
}

/// Its folder is a file system of 64 kB that only it has.
TEST_F(RightsOfTheLan, AFullDiskNeitherEndsNorHoldsUpTheIslandAndIsCounted) {
  fs::create_directory(file("small"));
  const auto mounted = "mount -t tmpfs -o size=64k small " + file("small") + " && exec \"$@\"";
  const std::vector<std::string> before{"unshare", "--mount", "sh", "-c", mounted, "sh"};
  auto probe = before;
  probe.insert(probe.end(), {"stat", "-f", "-c", "%T", file("small")});
  if (const auto made = support::run_to_end(probe); made.output != "tmpfs\n")
    GTEST_SKIP() << "no file system in a private mount namespace: " << made.errors;
  give(kMayRead, "small/home.audit");
  start_island(before);
  const auto small = "/proc/" + std::to_string(island_->pid()) + "/root" + file("small");
  sets("on");
  ASSERT_THAT(requests_in(small + "/home.audit"), ElementsAre("lan on accepted"));
  fill(small);
  sets("off");
  ASSERT_TRUE(says(*island_, "home.audit: cannot write: No space left on device; lines of the audit are lost"))
      << island_->errors();
  for (const auto* value : {"on", "off"}) is_refused(value);
  const auto errors = island_->errors();
  EXPECT_EQ(errors.find("are lost", errors.find("are lost") + 1), errors.npos) << "said once: " << errors;
  fs::remove(small + "/filler");
  sets("on");
  EXPECT_TRUE(says(*island_, "home.audit: is written again; 3 lines were lost")) << island_->errors();
  EXPECT_THAT(requests_in(small + "/home.audit"), ElementsAre("lan on accepted", "lost 3", "lan on accepted"));
}

}  // namespace
}  // namespace rubicon::ecology
