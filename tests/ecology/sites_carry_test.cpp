#include "ecology/realm_of_sites.h"
#include "support/people.h"

namespace rubicon::ecology {
namespace {

using testing::HasSubstr;
using testing::Not;

/// People of the host of lab. Its islands run as root, like this test.
constexpr unsigned kAsker = 65001, kOtherUser = 65002, kSiteGroup = 1;

/// Who asks through a carrier, at a broker with a realm.
class CarriersOfSites : public RealmOfSites {
 protected:
  static std::string lamp(int id, const std::string& what) {
    return std::to_string(id) + ":proxy.dummy-1.hall.actuator.switch-1." + what;
  }
  support::Outcome as(unsigned user, const std::string& host, std::vector<std::string> words) {
    words.insert(words.begin(), RUBICON_BINARY_DIR "/bin/rubicon");
    return support::run_to_end(support::as_user(user, kSiteGroup, at(host, std::move(words))));
  }
  void expect_refused(const std::string& host, std::vector<std::string> words, const std::string& why) {
    expect_refused(run(host, std::move(words)), why);
  }
  static void expect_refused(const support::Outcome& refused, const std::string& why) {
    EXPECT_NE(refused.code, 0) << refused.output;
    EXPECT_THAT(refused.output + refused.errors, HasSubstr(why));
  }
};

/// The robot meets programs of its host only, which is that of hall. It judges both by their names.
TEST_F(CarriersOfSites, ARobotOfOneSiteJudgesThoseOfAnotherForWhomItsCarrierMayVouch) {
  make_realm();
  trust("authority", {"change", "hall", "--island", "1", "--island", "7"});
  join("desk", {});
  join("guest", {});
  start_broker();
  const auto hall = island(1, mqtt("hall", "authority") + ", carry: [{what: 7, from: host, to: mqtt}]",
                           "rights: [{who: everybody, may: all}]\n");
  const auto robot = island_on("site1", 7, "engine: host",
                               "rights: [{who: \"user:root\", may: vouch, names: [\"member:*\"]},"
                               " {who: \"user:root\", may: [read, demand], keys: [\"**\"]},"
                               " {who: \"member:desk@root\", may: set, keys: [\"**\"]}]\n");
  const auto desk = tool("desk", mqtt("desk")), guest = tool("guest", mqtt("guest"));
  EXPECT_TRUE(until("desk", {"set", lamp(7, "command"), "on", "--config", desk}, "")) << hall->errors();
  EXPECT_TRUE(until("guest", {"get", lamp(7, "value"), "--config", guest}, "on")) << robot->errors();
  expect_refused("guest", {"set", lamp(7, "command"), "off", "--config", guest},
                 "member:guest@root may not set proxy.dummy-1.hall.actuator.switch-1.command");
  EXPECT_TRUE(until("desk", {"get", lamp(7, "value"), "--config", desk}, "on"));
}

/// Ann of the host of lab asks hall, which lets lab vouch, and attic, which does not. What the user may that lab runs
/// as is another question.
TEST_F(CarriersOfSites, AUserOfOneSiteIsJudgedAtAnotherWhereItsCarrierMayVouch) {
  if (!support::share_folder(meeting_of("site2"), 0, kSiteGroup)) GTEST_SKIP() << "needs root of the host";
  if (as(kAsker, "site2", {"--version"}).code != 0) GTEST_SKIP() << "needs setpriv, and programs that all may run";
  make_realm();
  join("lab", {"--island", "2"});
  join("attic", {"--island", "3"});
  start_broker();
  const std::string user =
                        "rights: [{who: \"member:lab\", may: [read, demand], keys: [\"**\"]},"
                        " {who: \"user:65001@lab\", may: set, keys: [\"proxy.*.*.actuator.switch-1.command\"]}",
                    vouch = ", {who: \"member:lab\", may: vouch, names: [\"user:*\"]}";
  const auto hall = island(1, mqtt("hall", "authority"), user + vouch + "]\n");
  const auto attic = island(3, mqtt("attic"), user + "]\n");
  const auto lab = island(2, mqtt("lab") + ", carry: [{what: [1, 3], from: mqtt, to: host}]",
                          "rights: [{who: everybody, may: all}]\n");
  EXPECT_TRUE(until("site2", {"get", lamp(1, "description")}, "switch")) << lab->errors() << hall->errors();
  EXPECT_TRUE(until("site2", {"islands"}, "site3")) << attic->errors();
  const auto done = as(kAsker, "site2", {"set", lamp(1, "command"), "on"});
  EXPECT_EQ(done.code, 0) << done.output << done.errors;
  EXPECT_TRUE(until("site2", {"get", lamp(1, "value")}, "on"));
  expect_refused(as(kOtherUser, "site2", {"set", lamp(1, "command"), "off"}), "user:65002@lab may not set");
  expect_refused("site2", {"set", lamp(1, "command"), "off"}, "user:root@lab may not set");
  expect_refused(as(kAsker, "site2", {"set", lamp(3, "command"), "on"}), "lab may not set");
  EXPECT_THAT(run("site2", {"get", lamp(3, "value")}).output, Not(HasSubstr("on")));
}

}  // namespace
}  // namespace rubicon::ecology
