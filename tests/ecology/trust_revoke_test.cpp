#include <gmock/gmock.h>

#include <chrono>
#include <csignal>

#include "ecology/trust_lan.h"
#include "support/conversation.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

/// An island on each of three hosts; the first host has the authority, the second one also a person.
class TrustOnThreeHosts : public TrustOnALan {
 protected:
  TrustOnThreeHosts() : TrustOnALan(3) {}

  void start_islands() {
    add_desk("admin");
    start_island();
    for (const int host : {1, 2}) {
      const auto name = "island-" + std::to_string(host + 1);
      add_member(name, host, {"--island", std::to_string(host + 1), "--role", "admin"});
      write(name + ".yaml", "island: {id: " + std::to_string(host + 1) + ", name: " + name +
                                "}\ntuples: {interfaces: [cable], lease: 500ms, trust: ./" + name +
                                "}\nnetworks:\n  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: "
                                "{}}}}}\n");
      (host == 1 ? second_ : third_) = island_on(host, name + ".yaml");
    }
  }
  static std::string lamp_of(int island) { return std::to_string(island) + ":proxy.dummy-1.den.actuator.switch-1"; }
  void expect_on(int island, Process& process) const {
    const auto value = local({"get", lamp_of(island) + ".value"});
    EXPECT_EQ(value.output, "on\n") << value.errors << process.errors();
  }

  std::unique_ptr<Process> second_, third_;
};

TEST_F(TrustOnThreeHosts, ARevokedMemberIsShutOutOfIslandsThatAreThereAndOfOneThatWakes) {
  start_islands();
  for (const int island : {1, 2, 3}) {
    const auto commanded = person({"set", lamp_of(island) + ".command", "on"});
    ASSERT_EQ(commanded.code, 0) << island << commanded.errors << island_->errors();
  }
  third_->signal(SIGSTOP);
  ASSERT_EQ(authority({"revoke", "desk"}).code, 0);
  ASSERT_TRUE(says(*second_, "was revoked on")) << second_->errors();
  EXPECT_NE(person({"set", lamp_of(2) + ".command", "off"}).code, 0) << second_->errors();
  expect_on(2, *second_);
  EXPECT_THAT(third_->errors(), Not(HasSubstr("was revoked on")));
  third_->signal(SIGCONT);
  ASSERT_TRUE(says(*third_, "was revoked on")) << third_->errors();
  EXPECT_NE(person({"set", lamp_of(3) + ".command", "off"}).code, 0) << third_->errors();
  expect_on(3, *third_);
}

TEST_F(TrustOnThreeHosts, AnIslandThatWakesObeysBeforeItTakesACommandThatWaitedForIt) {
  start_islands();
  const auto lamp = "set " + lamp_of(3) + ".command ";
  ASSERT_TRUE(support::until(*second_, lamp + "on", 60s, [](const auto& answer) {
    return answer.value("verdict", "") == "applied";
  })) << third_->errors();
  third_->signal(SIGSTOP);
  second_->signal(SIGSTOP);
  ASSERT_EQ(authority({"revoke", "island-2"}).code, 0);
  ASSERT_TRUE(says(*island_, "was revoked on")) << island_->errors();
  third_->signal(SIGCONT);
  second_->signal(SIGCONT);
  const auto try_it = [&] { return support::ask(*second_, lamp + "off").value("verdict", ""); };
  for (int i = 0; i < 1000 && third_->errors().find("was revoked on") == std::string::npos; ++i)
    ASSERT_NE(try_it(), "applied") << i << third_->errors();
  ASSERT_TRUE(says(*third_, "was revoked on")) << third_->errors();
  EXPECT_NE(try_it(), "applied") << third_->errors();
  expect_on(3, *third_);
}

}  // namespace
}  // namespace rubicon::ecology
