#include <gmock/gmock.h>

#include <csignal>

#include "ecology/trust_lan.h"

namespace rubicon::ecology {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

/// An island that runs while its certificate, or those of others, change.
class TrustThatChanges : public TrustOnALan {
 protected:
  void SetUp() override {
    TrustOnALan::SetUp();
    if (IsSkipped()) return;
    add_desk("admin");
    start_island();
    const auto commanded = person({"set", kLampCommand, "on"});
    ASSERT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  }
  /// What the person sees of the lamp, a line for each change.
  std::unique_ptr<Process> watch() const {
    auto watching =
        start(1, {kToolProgram, "watch", kLampValue, "--json", "--trust", file("desk"), "--interfaces", "cable"});
    EXPECT_TRUE(watching->line_with(R"("value":"on")")) << watching->errors();
    return watching;
  }
  std::string days_left() const { return local({"get", "1:proxy.property.trust-days-left.value"}).output; }
};

TEST_F(TrustThatChanges, AReloadTakesTheNewCertificateAndSubscribersLoseNothing) {
  EXPECT_THAT(days_left(), AnyOf("730\n", "729\n"));
  const auto watching = watch();
  ASSERT_EQ(authority({"renew", "island-1", "--days", "100"}).code, 0);
  island_->signal(SIGHUP);
  ASSERT_TRUE(says(*island_, "trust: renewed")) << island_->errors();
  const auto commanded = person({"set", kLampCommand, "off"});
  EXPECT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  std::string seen;
  while (seen.find(R"("value":"off")") == seen.npos) {
    const auto line = watching->line();
    ASSERT_TRUE(line) << seen << watching->errors();
    seen += *line + '\n';
  }
  EXPECT_THAT(seen, Not(AnyOf(HasSubstr(R"("event":"deleted")"), HasSubstr(R"("event":"lost")"))))
      << "at most the quality changes for a moment";
  auto left = days_left();  // published once a second
  for (int i = 0; i < 600 && left.find("7") == 0; ++i) left = days_left();
  EXPECT_THAT(left, AnyOf("100\n", "99\n"));
}

TEST_F(TrustThatChanges, ABadFileDoesNotTakeTheIslandOutWhenAMemberIsRevoked) {
  const std::string name = "trust/members/island-1/permissions.p7s";
  const auto good = text_in(name);
  const auto watching = watch();
  write(name, "damaged");
  ASSERT_EQ(authority({"revoke", "desk"}).code, 0);
  ASSERT_TRUE(says(*island_, "this process goes on with what it has read before")) << island_->errors();
  EXPECT_THAT(island_->errors(), HasSubstr(file(name) + ": "));
  const auto value = local({"get", kLampValue});
  EXPECT_EQ(value.output, "on\n") << value.errors << island_->errors();
  EXPECT_NE(person({"set", kLampCommand, "off"}).code, 0) << island_->errors();
  write(name, good);
  const auto commanded = local({"set", kLampCommand, "off"});
  EXPECT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  EXPECT_THAT(island_->errors(), AllOf(Not(HasSubstr("left the ecology")), Not(HasSubstr("in the ecology again"))));
}

}  // namespace
}  // namespace rubicon::ecology
