#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kFlood = R"({"t":1767225602,"who":"guest","verdict":"refused","more":4900})";
constexpr const char* kLoss = R"({"t":1767225603,"lost":3})";

std::string audit_line(const std::string& who, const std::string& value, const std::string& verdict) {
  return R"({"t":1767225600.5,"who":")" + who + R"(","verb":"set","key":"proxy.a","value":")" + value +
         R"(","verdict":")" + verdict + R"(","why":")" + (verdict == "refused" ? "no rule allows it" : "") + "\"}";
}

/// The audit log of an island that does not run.
class TrustAudit : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    append({audit_line("desk", "on", "accepted"), audit_line("guest", "off", "refused"),
            audit_line("desk", "out", "refused")});
  }
  void append(const std::vector<std::string>& lines) const {
    std::ofstream file(audit_, std::ios::app);
    for (const auto& line : lines) file << line << "\n";
  }
  Outcome shown(std::vector<std::string> words) const {
    words.insert(words.begin(), {"trust", "audit", "--file", audit_});
    return rubicon(std::move(words));
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::string audit_ = folder_.file("home.audit");
};

TEST_F(TrustAudit, ShowsEachRequestInOneLine) {
  const auto all = shown({});
  EXPECT_EQ(all.code, 0) << all.errors;
  EXPECT_THAT(all.output, ContainsRegex("^[^\n]+ desk set proxy.a = on: accepted\n"
                                        "[^\n]+ guest set proxy.a = off: refused, no rule allows it\n"
                                        "[^\n]+ desk set proxy.a = out: refused, no rule allows it\n$"));
}

TEST_F(TrustAudit, ShowsWhoHandedAMessageOn) {
  append(
      {R"({"t":1767225601,"who":"maid","verb":"set","key":"proxy.b","verdict":"accepted","through":"island-2","why":""})"});
  EXPECT_THAT(shown({}).output, HasSubstr("maid set proxy.b: accepted, through island-2\n"));
}

TEST_F(TrustAudit, RefusedLeavesOutWhatWasAccepted) {
  const auto refused = shown({"--refused"});
  EXPECT_EQ(refused.code, 0) << refused.errors;
  EXPECT_THAT(refused.output, AllOf(HasSubstr("= off: refused"), HasSubstr("= out: refused"), Not(HasSubstr("= on"))));
  const auto of_guest = shown({"--refused", "--name", "guest", "--json"});
  EXPECT_EQ(of_guest.output, audit_line("guest", "off", "refused") + "\n");
}

TEST_F(TrustAudit, SaysHowManyLinesAFloodOrAFullDiskCost) {
  append({kFlood, kLoss});
  const auto all = shown({});
  EXPECT_THAT(all.output, AllOf(HasSubstr("  guest: refused 4900 times more\n"),
                                HasSubstr("  3 lines before could not be written\n")));
  EXPECT_THAT(shown({"--refused"}).output, HasSubstr("4900 times more"));
}

TEST_F(TrustAudit, FollowGoesOnWithNewLinesAlsoInTheNextFile) {
  std::ofstream(audit_, std::ios::app) << R"({"t":1767225601,"who":"gue)";
  Process follower({kProgram, "trust", "audit", "--file", audit_, "--follow", "--refused"});
  EXPECT_THAT(follower.line().value_or(""), HasSubstr("= off: refused"));
  EXPECT_THAT(follower.line().value_or(""), HasSubstr("= out: refused"));
  std::ofstream(audit_, std::ios::app) << R"(st","verb":"set","key":"proxy.late","verdict":"refused"})"
                                       << "\n";
  EXPECT_THAT(follower.line().value_or(""), HasSubstr("guest set proxy.late: refused")) << "no half of a line";
  append({audit_line("desk", "1", "accepted"), audit_line("desk", "2", "refused")});
  EXPECT_THAT(follower.line().value_or(""), HasSubstr("= 2: refused"));
  append({audit_line("desk", "3", "refused")});
  fs::rename(audit_, audit_ + ".1");
  append({audit_line("desk", "4", "refused")});
  for (const auto* value : {"3", "4"})
    EXPECT_THAT(follower.line().value_or(""), HasSubstr("= " + std::string(value) + ": refused"));
  follower.close_output();
  EXPECT_EQ(follower.exit_code(), 0) << follower.errors();
}

TEST_F(TrustAudit, NamesTheLogsOfSeveralIslands) {
  const auto asked = [this] {
    return support::run_to_end({"env", "RUBICON_REALM=" + folder_.file("realm"), kProgram, "trust", "audit"});
  };
  const auto none = asked();
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.errors, HasSubstr("expected --file FILE or --config FILE"));
  folder_.write("home.yaml",
                small_island(1, "{engine: dds}") + "state: {file: home.state}\naudit: {file: home.audit}\n");
  EXPECT_THAT(asked().output, HasSubstr("desk set proxy.a = on: accepted")) << "that of the only island";
  folder_.write("lab.yaml", small_island(2, "{engine: dds}") + "state: {file: lab.state}\n");
  const auto several = asked();
  EXPECT_EQ(several.code, 2);
  EXPECT_THAT(several.errors, AllOf(HasSubstr(audit_), HasSubstr(folder_.file("lab.state.audit"))));
}

}  // namespace
}  // namespace rubicon::cli
