#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ecology/trust_lan.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::Not;

/// An island with an audit, `desk` with all rights on another host, and `guest` with none.
class AuditOfAnIsland : public TrustOnALan {
 protected:
  void make_members() const {
    add_desk("admin");
    add_member("guest", 1, {"--role", "visitor"});
  }
  void start_with_audit(const std::string& audit, const std::vector<std::string>& before = {}) {
    configure("audit: {file: " + audit +
              "}\nrights:\n  - {who: admin, may: all}\n"
              "  - {who: visitor, may: read, keys: [\"proxy.**\"]}\n");
    start_island(before);
  }
  /// `WHO VALUE VERDICT` of each line of a file, in order.
  static std::vector<std::string> wishes_in(const std::string& path) {
    std::vector<std::string> all;
    std::ifstream lines(path);
    for (std::string text; std::getline(lines, text);) {
      if (text.find_first_not_of(' ') == text.npos) continue;
      const auto line = json::parse(text, nullptr, false);
      if (line.contains("lost")) {
        all.push_back("lost " + std::to_string(line["lost"].get<int>()));
        continue;
      }
      EXPECT_EQ("1:" + line.value("key", ""), kLampCommand) << text;
      EXPECT_EQ(line.value("verb", ""), "set") << text;
      EXPECT_FALSE(line.value("serial", "").empty()) << text;
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
  void desk_sets(const std::string& value) {
    const auto done = person({"set", kLampCommand, value});
    EXPECT_EQ(done.code, 0) << done.errors << island_->errors();
  }
  void guest_sets(const std::string& value) {
    const auto refused = on(1, {"set", kLampCommand, value, "--trust", file("guest")});
    EXPECT_EQ(refused.code, 3) << refused.errors << island_->errors();
  }
};

TEST_F(AuditOfAnIsland, AndTheServiceHaveWhatWasSetAndNotTheLogThatOthersRead) {
  make_members();
  start_with_audit("home.audit");
  desk_sets("on");
  EXPECT_THAT(island_->errors(), HasSubstr("actuator.switch-1 = 'on' by")) << "the user of the island sees it";
  const auto log = on(1, {"log", "--trust", file("guest")});
  EXPECT_THAT(log.output, HasSubstr("is up")) << log.errors;
  EXPECT_THAT(log.output, Not(HasSubstr("switch-1")));
}

TEST_F(AuditOfAnIsland, HasOneLineForEachWishInOrder) {
  make_members();
  start_with_audit("home.audit");
  std::vector<std::string> expected;
  for (const auto* value : {"on", "off", "on"}) {
    desk_sets(value);
    guest_sets(value);
    expected.push_back(std::string("desk ") + value + " accepted");
    expected.push_back(std::string("guest ") + value + " refused");
  }
  EXPECT_THAT(wishes_in(file("home.audit")), ElementsAreArray(expected));
  const auto shown = authority({"audit", "--config", file("home.yaml"), "--name", "guest", "--json"});
  EXPECT_EQ(shown.code, 0) << shown.errors;
  EXPECT_EQ(std::count(shown.output.begin(), shown.output.end(), '\n'), 3) << shown.output;
  EXPECT_THAT(shown.output, HasSubstr("\"why\":\"guest may not set"));
  const auto refused = authority({"audit", "--config", file("home.yaml"), "--refused"});
  EXPECT_EQ(std::count(refused.output.begin(), refused.output.end(), '\n'), 3) << refused.output;
}

TEST_F(AuditOfAnIsland, GoesOnInANewFileAfterLogrotateRenamedIt) {
  make_members();
  start_with_audit("home.audit");
  desk_sets("on");
  fs::rename(file("home.audit"), file("home.audit-20260101"));
  desk_sets("off");
  island_->signal(SIGHUP);
  ASSERT_TRUE(says(*island_, "reloaded " + file("home.yaml"))) << island_->errors();
  desk_sets("on");
  EXPECT_THAT(wishes_in(file("home.audit-20260101")), ElementsAre("desk on accepted", "desk off accepted"));
  EXPECT_THAT(wishes_in(file("home.audit")), ElementsAre("desk on accepted"));
}

/// Its folder is a file system of 64 kB that only it has.
TEST_F(AuditOfAnIsland, AFullDiskNeitherEndsNorHoldsUpTheIslandAndIsCounted) {
  make_members();
  fs::create_directory(file("small"));
  const auto mounted = "mount -t tmpfs -o size=64k small " + file("small") + " && exec \"$@\"";
  const std::vector<std::string> before{"unshare", "--mount", "sh", "-c", mounted, "sh"};
  auto probe = before;
  probe.insert(probe.end(), {"stat", "-f", "-c", "%T", file("small")});
  if (const auto made = support::run_to_end(probe); made.output != "tmpfs\n")
    GTEST_SKIP() << "no file system in a private mount namespace: " << made.errors;
  start_with_audit("small/home.audit", before);
  const auto small = "/proc/" + std::to_string(island_->pid()) + "/root" + file("small");
  desk_sets("on");
  ASSERT_THAT(wishes_in(small + "/home.audit"), ElementsAre("desk on accepted"));
  fill(small);
  desk_sets("off");
  ASSERT_TRUE(says(*island_, "home.audit: cannot write: No space left on device; lines of the audit are lost"))
      << island_->errors();
  for (const auto* value : {"on", "off"}) guest_sets(value);
  const auto errors = island_->errors();
  EXPECT_EQ(errors.find("are lost", errors.find("are lost") + 1), errors.npos) << "said once: " << errors;
  fs::remove(small + "/filler");
  desk_sets("on");
  EXPECT_TRUE(says(*island_, "home.audit: is written again; 3 lines were lost")) << island_->errors();
  EXPECT_THAT(wishes_in(small + "/home.audit"), ElementsAre("desk on accepted", "lost 3", "desk on accepted"));
}

}  // namespace
}  // namespace rubicon::ecology
