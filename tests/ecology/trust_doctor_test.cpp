#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <sstream>

#include "ecology/lan.h"
#include "support/process.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using support::Outcome;
using support::Process;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kSilent = "show no component to this program";

/// Host 0 has an island with trust, host 1 one without; each of them has a participant for its shell too. The doctor is
/// on host 2.
class DoctorBesideTrust : public testing::Test {
 protected:
  void SetUp() override {
    if (!lan_.made()) GTEST_SKIP() << lan_.reason();
    folder_ = fs::path(testing::TempDir()) /
              ("rubicon_doctor_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_island("closed.yaml", 1, "./trust");
    ASSERT_EQ(run(0, {"trust", "dds", "init", "--trust", file("trust")}).code, 0);
  }
  void TearDown() override {
    islands_.clear();
    fs::remove_all(folder_);
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  void write_island(const std::string& name, int id, const std::string& trust) const {
    std::ofstream(file(name)) << "island: {id: " << id << ", name: house}\n"
                              << "tuples: {interfaces: [cable], trust: " << trust << "}\nnetworks: {}\n";
  }
  Process& start(int host, const std::string& configuration) {
    const Host::Visit visit(lan_.host(host));
    auto& island = *islands_.emplace_back(std::make_unique<Process>(
        std::vector<std::string>{RUBICON_BINARY_DIR "/bin/rubicon-proxy", "run", file(configuration), "--shell"}));
    island.write("stats\n");
    EXPECT_TRUE(island.line_with("\"ok\"")) << island.errors();
    return island;
  }
  Process& start_closed() { return start(0, "closed.yaml"); }
  Process& start_plain() {
    write_island("plain.yaml", 2, "no");
    return start(1, "plain.yaml");
  }

  Outcome run(int host, std::vector<std::string> words) const {
    const Host::Visit visit(lan_.host(host));
    words.insert(words.begin(), RUBICON_BINARY_DIR "/bin/rubicon");
    return support::run_to_end(std::move(words));
  }
  Outcome doctor(const std::string& trust) const {
    return run(2, {"doctor", "--for", "100ms", "--interfaces", "cable", "--trust", trust});
  }

  Lan lan_{3};
  fs::path folder_;
  std::vector<std::unique_ptr<Process>> islands_;
};

TEST_F(DoctorBesideTrust, WithoutTrustItCountsWhoShowsNoComponent) {
  start_closed();
  const auto told = doctor("no");
  EXPECT_EQ(told.code, 1) << told.output;
  EXPECT_THAT(told.output, HasSubstr("2 participants of domain 0 show no component to this program: with trust"));
  EXPECT_THAT(told.output, AllOf(HasSubstr("--trust FOLDER"), HasSubstr("and domain 0 on cable")));
}

TEST_F(DoctorBesideTrust, WithoutTrustItSaysSoBesideAnIslandThatItSees) {
  start_closed();
  start_plain();
  const auto told = doctor("no");
  EXPECT_EQ(told.code, 0) << told.output;
  EXPECT_THAT(told.output, AllOf(HasSubstr("island 2 house answers"), ContainsRegex("note +trust +2 participants "),
                                 HasSubstr(kSilent)));
}

TEST_F(DoctorBesideTrust, WithTrustItNamesAnIslandWithout) {
  start_plain();
  const auto told = doctor(file("trust"));
  EXPECT_EQ(told.code, 1) << told.output;
  EXPECT_THAT(told.output, HasSubstr("island 2 house takes part without trust, this program with"));
}

TEST_F(DoctorBesideTrust, WithTrustItCountsWhoShowsNoComponent) {
  start_closed();
  start_plain();
  const auto told = doctor(file("trust"));
  EXPECT_EQ(told.code, 0) << told.output;
  EXPECT_THAT(told.output,
              AllOf(HasSubstr("island 1 house answers"),
                    HasSubstr("2 participants of domain 0 show no component to this program: without trust")));
}

TEST_F(DoctorBesideTrust, AmongItsOwnKindItCountsNone) {
  start_closed();
  const auto told = doctor(file("trust"));
  EXPECT_EQ(told.code, 0) << told.output;
  EXPECT_THAT(told.output,
              AllOf(HasSubstr("island 1 house answers"), Not(HasSubstr("participants of")), Not(HasSubstr("refused"))));
}

/// It does not know that it is revoked, tries again each second, and counts once.
TEST_F(DoctorBesideTrust, AnIslandCountsWhomItRefused) {
  ASSERT_EQ(run(0, {"trust", "dds", "add", "desk", "--out", file("desk.trust"), "--phrase-file", file("phrase"),
                    "--trust", file("trust")})
                .code,
            0);
  ASSERT_EQ(run(2, {"trust", "dds", "join", file("desk.trust"), "--yes", "--phrase-file", file("phrase"), "--trust",
                    file("desk")})
                .code,
            0);
  ASSERT_EQ(run(0, {"trust", "dds", "revoke", "desk", "--trust", file("trust")}).code, 0);
  auto& island = start_closed();
  const auto stranger = doctor(file("desk"));
  EXPECT_THAT(stranger.output,
              HasSubstr("2 participants of domain 0 show no component to this program: without trust"));
  EXPECT_THAT(island.errors(), HasSubstr("'desk' was refused: its certificate is revoked"));
  const auto told = doctor(file("trust"));
  EXPECT_THAT(told.output, ContainsRegex("island 1 house refused 1 peer since its start; at [^\n]+'desk' was refused: "
                                         "its certificate is revoked"));
  EXPECT_EQ(told.code, 0) << told.output;
}

/// Of two strangers only the one with the higher GUID, which is chance here, sees the certificate of the other: either
/// the tool or the island knows why. The tool knows in any case that others show it nothing.
TEST_F(DoctorBesideTrust, AToolOfAnotherRealmIsExplainedOnOneOfBothSides) {
  ASSERT_EQ(run(2, {"trust", "dds", "init", "--realm", "Other", "--trust", file("other")}).code, 0);
  start_closed();
  const auto stranger = doctor(file("other"));
  EXPECT_EQ(stranger.code, 1) << stranger.output;
  EXPECT_THAT(stranger.output,
              AllOf(HasSubstr("the certificate of this program, local, has"), HasSubstr("and domain 0 on cable"),
                    HasSubstr("2 participants of domain 0 show no component to this program: without trust, of "
                              "another realm or refused")));
  const auto told = doctor(file("trust"));
  EXPECT_EQ(told.code, 0) << told.output;
  const bool tool_knows =
      std::regex_search(stranger.output, std::regex("'island-1' was refused, its certificate is of another realm"));
  const bool island_knows = std::regex_search(
      told.output, std::regex("island 1 house refused [1-9][0-9]* peers? since its start; at [^\n]*'local'[^\n]* was "
                              "refused, its certificate is of another realm"));
  EXPECT_NE(tool_knows, island_knows) << stranger.output << told.output;
}

/// RLIMIT_CORE is 0 before it has its key, whatever the unit says.
TEST_F(DoctorBesideTrust, AnIslandWithTrustWritesNoCoreFile) {
  const auto limits = [](const Process& process) {
    std::ostringstream text;
    text << std::ifstream("/proc/" + std::to_string(process.pid()) + "/limits").rdbuf();
    return text.str();
  };
  EXPECT_THAT(limits(start_closed()), ContainsRegex("Max core file size +0 +0 "));
}

}  // namespace
}  // namespace rubicon::ecology
