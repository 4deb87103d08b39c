#include <gmock/gmock.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ecology/trust_lan.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using std::chrono::sys_days;
using std::chrono::system_clock;
using std::chrono::year;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using Time = std::chrono::sys_seconds;

constexpr Time kNeverSet = sys_days(year(1970) / 1 / 4), kFarAhead = sys_days(year(2100) / 1 / 1);

Time now_here() {
  return std::chrono::floor<std::chrono::seconds>(system_clock::now());
}

/// Programs whose clock of the wall is another one.
class WrongClocks : public TrustOnALan {
 protected:
  void set_clock(Time time) const { write_ahead((time - now_here()).count()); }
  void mend_clock() const { write_ahead(0); }
  /// In front of a program.
  std::vector<std::string> with_clock() const {
    // The library of a sanitizer must be loaded first.
    return {"env", "LD_PRELOAD=" RUBICON_OTHER_CLOCK, "OTHER_CLOCK=" + file("clock"),
            "ASAN_OPTIONS=verify_asan_link_order=0"};
  }
  /// `rubicon` on host 0 by that clock.
  Outcome tool(std::vector<std::string> words) const {
    auto all = with_clock();
    all.push_back(kToolProgram);
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--trust", file("trust")});
    const Host::Visit visit(lan_.host(0));
    return support::run_to_end(all);
  }

 private:
  void write_ahead(std::int64_t seconds) const {
    std::fstream out(file("clock"), std::ios::binary | std::ios::in | std::ios::out);
    if (!out) out.open(file("clock"), std::ios::binary | std::ios::out);
    out.write(reinterpret_cast<const char*>(&seconds), sizeof seconds);
  }
};

TEST_F(WrongClocks, AnIslandDoesNotStartIn1970) {
  make_realm();
  set_clock(kNeverSet);
  const auto ended = run_island(with_clock());
  EXPECT_EQ(ended.code, 1) << ended.errors;
  EXPECT_THAT(ended.errors, AllOf(HasSubstr(file("trust/")), HasSubstr("the clock of this host says 1970-01-0"),
                                  HasSubstr("expected a time after 2020; set the clock"), Not(HasSubstr("is up"))));
  mend_clock();
  EXPECT_EQ(run_island(with_clock()).code, 0) << "the same start with a good clock";
}

TEST_F(WrongClocks, AnIslandDoesNotStartIn2100) {
  make_realm();
  set_clock(kFarAhead);
  const auto ended = run_island(with_clock());
  EXPECT_EQ(ended.code, 1) << ended.errors;
  EXPECT_THAT(ended.errors, AllOf(HasSubstr(file("trust/")), HasSubstr(" ended on "),
                                  HasSubstr("and the clock says 2100-01-01"), Not(HasSubstr("is up"))));
}

TEST_F(WrongClocks, AnIslandDoesNotStartAfterItsEnd) {
  make_realm();
  set_clock(now_here() + 24h * 800);
  const auto ended = run_island(with_clock());
  EXPECT_EQ(ended.code, 1) << ended.errors;
  EXPECT_THAT(ended.errors,
              AllOf(HasSubstr(file("trust/members/island-1/certificate.pem: CN=island-1")), HasSubstr(" ended on "),
                    HasSubstr("renew it, or set the clock"), Not(HasSubstr("is up"))));
}

TEST_F(WrongClocks, AMemberThatEndedByTheClockOfTheIslandIsRefusedAndNamed) {
  make_realm();
  add_member("desk", 1, {"--role", "admin", "--days", "1"});
  mend_clock();
  start_island(with_clock());
  const auto before = person({"set", kLampCommand, "on"});
  ASSERT_EQ(before.code, 0) << before.errors << island_->errors();
  set_clock(now_here() + 48h);
  const auto refused = person({"set", kLampCommand, "off"});
  EXPECT_EQ(refused.code, 8) << refused.errors << island_->errors();
  EXPECT_TRUE(says(*island_, "'desk' was refused: Certificate not valid: error: certificate has expired"))
      << island_->errors();
  mend_clock();
  const auto after = person({"get", kLampValue});
  EXPECT_EQ(after.output, "on\n") << after.errors << island_->errors();
}

TEST_F(WrongClocks, ToolsSayThatItIsTheClock) {
  make_realm();
  for (const auto& [time, text] : {std::pair(kNeverSet, "the clock of this host says 1970-01-0"),
                                   std::pair(kFarAhead, "the clock says 2100-01-01")}) {
    set_clock(time);
    for (const auto& words : std::vector<std::vector<std::string>>{{"get", kLampValue, "--interfaces", "cable"},
                                                                   {"trust", "dds", "add", "desk", "--here"},
                                                                   {"trust", "dds", "revoke", "local"}}) {
      const auto refused = tool(words);
      EXPECT_EQ(refused.code, 1) << words[1] << refused.errors;
      EXPECT_THAT(refused.errors, HasSubstr(text)) << words[1];
    }
  }
  mend_clock();
  EXPECT_THAT(tool({"trust", "dds", "show"}).output, AllOf(Not(HasSubstr("desk")), Not(HasSubstr("revoked on"))));
}

/// A unit runs `init` before each start of its island.
TEST_F(WrongClocks, InitMakesNothingIn1970AndIsNoReasonAgainstAStartLater) {
  set_clock(kNeverSet);
  const std::vector<std::string> start{"trust", "dds", "init", "--for", file("home.yaml")};
  const auto refused = tool(start);
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("the clock of this host says 1970-01-0"));
  EXPECT_FALSE(std::filesystem::exists(file("trust/identity-ca.pem")));
  make_realm();
  EXPECT_EQ(tool(start).code, 0) << "there is a realm, so the island tries to start, and says what is wrong";
}

/// When the certificate of a member ends, as `trust dds show --json` says.
Time end_of(const std::string& member, const std::string& shown) {
  const auto realm = nlohmann::json::parse(shown, nullptr, false);
  for (const auto& one : realm.value("members", nlohmann::json::array())) {
    if (one["name"] == member) return Time(std::chrono::seconds(one["expires"].get<std::int64_t>()));
  }
  return {};
}

TEST_F(WrongClocks, AnIslandWhoseClockRunsPastItsEndComesBackWhenItIsSet) {
  add_desk("admin");
  ASSERT_EQ(authority({"renew", "island-1", "--days", "1"}).code, 0);
  const auto end = end_of("island-1", authority({"show", "--json"}).output);
  ASSERT_GT(end, now_here());
  set_clock(end - 20s);
  start_island(with_clock());
  const auto before = person({"set", kLampCommand, "on"});
  ASSERT_EQ(before.code, 0) << before.errors << island_->errors();
  ASSERT_TRUE(says(*island_, "this process left the ecology")) << island_->errors();
  EXPECT_THAT(island_->errors(), ContainsRegex("the certificate of 'island-1' ended at 20[^\n]* Renew it"));
  EXPECT_EQ(person({"get", kLampValue}).code, 8) << island_->errors();
  mend_clock();
  ASSERT_TRUE(says(*island_, "this process is in the ecology again")) << island_->errors();
  const auto after = person({"set", kLampCommand, "off"});
  EXPECT_EQ(after.code, 0) << after.errors << island_->errors();
}

TEST_F(WrongClocks, AnIslandWhoseClockIsSetGoesOn) {
  add_desk("admin");
  mend_clock();
  start_island(with_clock());
  set_clock(kNeverSet);
  EXPECT_NE(person({"set", kLampCommand, "off"}).code, 0) << "no certificate is valid by that clock";
  EXPECT_TRUE(says(*island_, "'desk' was refused: Certificate not valid: error: certificate is not yet valid"))
      << island_->errors();
  for (const auto ahead : {1h, -1h, -24h * 300, 0h}) {
    set_clock(now_here() + ahead);
    auto commanded = person({"set", kLampCommand, "on"});
    // A handshake that ran while the clock was set times out; the next one follows within seconds.
    for (int i = 0; i < 5 && commanded.code == 8; ++i) commanded = person({"set", kLampCommand, "on"});
    EXPECT_EQ(commanded.code, 0) << ahead.count() << commanded.errors << island_->errors();
    const auto value = person({"get", kLampValue});
    EXPECT_EQ(value.output, "on\n") << ahead.count() << value.errors << island_->errors();
  }
}

}  // namespace
}  // namespace rubicon::ecology
