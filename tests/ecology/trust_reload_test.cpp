#include <gmock/gmock.h>

#include <chrono>
#include <csignal>

#include "ecology/trust_lan.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr const char* kMayRead = "  - {who: visitor, may: read, keys: [\"proxy.**\"]}\n";
constexpr const char* kMayNotReadTheLamp =
    "  - {who: visitor, may: read, keys: [\"proxy.**\"], not: [\"proxy.*.*.actuator.**\"]}\n";

/// An island whose rights change while a visitor on another host watches its lamp.
class RightsThatChange : public TrustOnALan {
 protected:
  void SetUp() override {
    TrustOnALan::SetUp();
    if (IsSkipped()) return;
    add_desk("visitor");
    give(kMayRead);
    start_island();
    const auto commanded = local({"set", kLampCommand, "on"});
    ASSERT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  }
  void give(const std::string& rights) const { configure("rights:\n  - {who: admin, may: all}\n" + rights); }
  /// How long it takes until the visitor sees that in a line.
  std::chrono::duration<double> reload(Process& watching, const std::string& expected) const {
    const auto begin = std::chrono::steady_clock::now();
    island_->signal(SIGHUP);
    EXPECT_TRUE(watching.line_with(expected)) << watching.errors() << island_->errors();
    return std::chrono::steady_clock::now() - begin;
  }
};

TEST_F(RightsThatChange, AReloadTakesATupleFromASubscriberWithinASecondAndGivesItBack) {
  const auto watching =
      start(1, {kToolProgram, "watch", kLampValue, "--json", "--trust", file("desk"), "--interfaces", "cable"});
  ASSERT_TRUE(watching->line_with(R"("value":"on")")) << watching->errors() << island_->errors();
  give(kMayNotReadTheLamp);
  EXPECT_LT(reload(*watching, R"("event":"deleted")"), 1s);
  const auto hidden = person({"get", kLampValue});
  EXPECT_NE(hidden.code, 0) << hidden.output;
  give(kMayRead);
  EXPECT_LT(reload(*watching, R"("value":"on")"), 1s);
  EXPECT_EQ(person({"get", kLampValue}).output, "on\n");
}

TEST_F(RightsThatChange, APageOfAPersonSaysWhoseRightsItHas) {
  const auto made = support::run_to_end({kToolProgram, "token", "panel", "--file", file("web.tokens")});
  ASSERT_EQ(made.code, 0) << made.errors;
  const auto page = start(1, {kToolProgram, "web", "--listen", "127.0.0.1:0", "--tokens", file("web.tokens"), "--trust",
                              file("desk"), "--interfaces", "cable"});
  ASSERT_TRUE(page->line_with("open ")) << page->errors();
  EXPECT_THAT(page->errors(), HasSubstr("islands judge this page by the rights of desk"));
}

}  // namespace
}  // namespace rubicon::ecology
