#include <gmock/gmock.h>

#include "ecology/trust_lan.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST_F(TrustOnALan, APersonWhoJoinedCommandsALampOfAnotherHost) {
  add_desk("admin");
  start_island();
  const auto commanded = person({"set", kLamp, "on"});
  EXPECT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  const auto value = person({"get", kLamp});
  EXPECT_EQ(value.output, "on\n") << value.errors;
  const auto phrase = text_in("desk.phrase");
  EXPECT_THAT(island_->errors(), AllOf(Not(HasSubstr("PRIVATE")), Not(HasSubstr(phrase.substr(0, phrase.size() - 1)))));
}

TEST_F(TrustOnALan, WhoHasNoCertificateSeesNoIslandAndIsToldWhy) {
  add_desk("admin");
  start_island();
  const auto blind = on(1, {"get", kLamp, "--trust", "no"});
  EXPECT_EQ(blind.code, 8) << blind.errors << island_->errors();
  const auto told = on(1, {"doctor", "--trust", "no", "--for", "100ms"});
  EXPECT_EQ(told.code, 1) << told.output << told.errors;
  EXPECT_THAT(told.output, AllOf(HasSubstr("no island"), HasSubstr("show no component to this program: with trust")));
}

TEST_F(TrustOnALan, ARevokedPersonIsShutOut) {
  add_desk("admin");
  start_island();
  const auto commanded = person({"set", kLamp, "on"});
  ASSERT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  const auto revoked = authority({"revoke", "desk"});
  ASSERT_EQ(revoked.code, 0) << revoked.errors;
  const auto refused = person({"set", kLamp, "off"});
  EXPECT_NE(refused.code, 0) << refused.output << island_->errors();
  EXPECT_EQ(authority({"get", kLamp}).code, 2) << "trust dds get is no command";
  const auto value = local({"get", kLamp});
  EXPECT_EQ(value.output, "on\n") << value.errors << island_->errors();
}

TEST_F(TrustOnALan, AnotherRealmSeesNothing) {
  add_desk("admin");
  start_island();
  const auto made = on(1, {"trust", "dds", "init", "--trust", file("other")});
  ASSERT_EQ(made.code, 0) << made.errors;
  const auto blind = on(1, {"get", kLamp, "--trust", file("other")});
  EXPECT_EQ(blind.code, 8) << blind.errors << island_->errors();
}

TEST_F(TrustOnALan, AnIslandWithoutItsCertificateDoesNotStart) {
  add_desk("admin");
  fs::remove(file("trust/members/island-1/key.pem"));
  const auto ended = run_island();
  EXPECT_EQ(ended.code, 1) << ended.errors;
  EXPECT_THAT(ended.errors, AllOf(HasSubstr("key.pem"), Not(HasSubstr("is up"))));
}

TEST_F(TrustOnALan, AMemberWithoutRightsMayNothing) {
  add_desk("guest");
  start_island();
  const auto commanded = person({"set", kLamp, "on"});
  EXPECT_NE(commanded.code, 0) << commanded.output << island_->errors();
  const auto value = person({"get", kLamp});
  EXPECT_EQ(value.code, 8) << value.errors << island_->errors();
}

/// The file was changed since its start.
TEST_F(TrustOnALan, MayAnswersByTheRulesThatTheRunningIslandHasInForce) {
  add_desk("guest");
  const auto rules = [this](const std::string& lamp) {
    configure("rights:\n  - {who: admin, may: all}\n  - {who: guest, may: read, keys: [\"proxy.**\"]}\n" + lamp);
  };
  rules("  - {who: desk, may: set, keys: [\"proxy.*.den.actuator.*.command\"]}\n");
  start_island();
  rules("");
  const std::vector<std::string> question{"trust", "may", "desk", "set", "proxy.dummy-1.den.actuator.switch-1.command"};
  const auto yes = local(question);
  EXPECT_EQ(yes.code, 0) << yes.errors << island_->errors();
  EXPECT_THAT(yes.output, HasSubstr("yes: rule 3 (island 1:"));
  const auto of_itself = person(question);
  EXPECT_EQ(of_itself.code, 0) << of_itself.errors << "it may read the rules, and knows its roles";
  auto offline = question;
  offline.insert(offline.end(), {"--config", file("home.yaml")});
  EXPECT_EQ(local(offline).code, 3);
  const auto no = person({"trust", "may", "desk", "set", "proxy.settings.command"});
  EXPECT_EQ(no.code, 3) << no.errors;
  EXPECT_EQ(no.output, "no: no rule allows it\n");
}

}  // namespace
}  // namespace rubicon::ecology
