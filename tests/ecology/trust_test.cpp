#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "ecology/lan.h"
#include "support/process.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using support::Outcome;
using support::Process;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kIslandProgram = RUBICON_BINARY_DIR "/bin/rubicon-proxy";
const std::string kProgram = RUBICON_BINARY_DIR "/bin/rubicon";
constexpr const char* kLamp = "den.switch-1";

std::string text_in(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// Host 0 has the authority and an island with a lamp; host 1 is that of a person.
class TrustOnALan : public testing::Test {
 protected:
  void SetUp() override {
    if (!lan_.made()) GTEST_SKIP() << lan_.reason();
    folder_ = fs::path(testing::TempDir()) /
              ("rubicon_trust_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(file("home.yaml")) << "island: {id: 1, name: home}\n"
                                        "tuples: {interfaces: [cable], lease: 500ms, trust: ./trust}\n"
                                        "networks:\n"
                                        "  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: {}}}}}\n";
  }
  void TearDown() override {
    island_.reset();
    fs::remove_all(folder_);
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Outcome on(int host, std::vector<std::string> words, const std::string& input = {}) const {
    const Host::Visit visit(lan_.host(host));
    words.insert(words.begin(), kProgram);
    words.insert(words.end(), {"--interfaces", "cable"});
    return support::run_to_end(std::move(words), input);
  }
  Outcome authority(std::vector<std::string> words) const {
    words.insert(words.begin(), "trust");
    words.insert(words.end(), {"--trust", file("trust")});
    return on(0, std::move(words));
  }
  Outcome person(std::vector<std::string> words, const std::string& input = {}) const {
    words.insert(words.end(), {"--trust", file("desk")});
    return on(1, std::move(words), input);
  }
  /// What a person does at first: init, add, carry the file, join.
  void let_in(const std::string& role) const {
    const auto made = authority({"init"});
    ASSERT_EQ(made.code, 0) << made.errors;
    const auto added =
        authority({"add", "desk", "--role", role, "--out", file("desk.trust"), "--phrase-file", file("desk.phrase")});
    ASSERT_EQ(added.code, 0) << added.errors;
    const auto joined = person({"trust", "join", file("desk.trust"), "--yes", "--phrase-file", file("desk.phrase")});
    ASSERT_EQ(joined.code, 0) << joined.errors;
  }
  void start_island(std::vector<std::string> more = {}) {
    const Host::Visit visit(lan_.host(0));
    std::vector<std::string> words{kIslandProgram, "run", file("home.yaml"), "--shell"};
    words.insert(words.end(), more.begin(), more.end());
    island_ = std::make_unique<Process>(words);
    island_->write("stats\n");
    std::ignore = island_->line_with("\"ok\"");
  }

  Lan lan_{2};
  fs::path folder_;
  std::unique_ptr<Process> island_;
};

TEST_F(TrustOnALan, APersonWhoJoinedCommandsALampOfAnotherHost) {
  let_in("admin");
  start_island();
  const auto commanded = person({"set", kLamp, "on"});
  EXPECT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  const auto value = person({"get", kLamp});
  EXPECT_EQ(value.output, "on\n") << value.errors;
  const auto phrase = text_in(file("desk.phrase"));
  EXPECT_THAT(island_->errors(), AllOf(Not(HasSubstr("PRIVATE")), Not(HasSubstr(phrase.substr(0, phrase.size() - 1)))));
}

TEST_F(TrustOnALan, WhoHasNoCertificateSeesNoIslandAndIsToldWhy) {
  let_in("admin");
  start_island();
  const auto blind = on(1, {"get", kLamp, "--trust", "no"});
  EXPECT_EQ(blind.code, 8) << blind.errors << island_->errors();
  const auto told = on(1, {"doctor", "--trust", "no", "--for", "100ms"});
  EXPECT_EQ(told.code, 1) << told.output << told.errors;
  EXPECT_THAT(told.output, HasSubstr("no island"));
}

TEST_F(TrustOnALan, ARevokedPersonIsShutOut) {
  let_in("admin");
  start_island();
  const auto commanded = person({"set", kLamp, "on"});
  ASSERT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  const auto revoked = authority({"revoke", "desk"});
  ASSERT_EQ(revoked.code, 0) << revoked.errors;
  const auto refused = person({"set", kLamp, "off"});
  EXPECT_NE(refused.code, 0) << refused.output << island_->errors();
  EXPECT_EQ(authority({"get", kLamp}).code, 2) << "trust get is no command";
  const auto value = on(0, {"get", kLamp, "--trust", file("trust")});
  EXPECT_EQ(value.output, "on\n") << value.errors << island_->errors();
}

TEST_F(TrustOnALan, AnotherRealmSeesNothing) {
  let_in("admin");
  start_island();
  const auto made = on(1, {"trust", "init", "--trust", file("other")});
  ASSERT_EQ(made.code, 0) << made.errors;
  const auto blind = on(1, {"get", kLamp, "--trust", file("other")});
  EXPECT_EQ(blind.code, 8) << blind.errors << island_->errors();
}

TEST_F(TrustOnALan, AnIslandWithoutItsCertificateDoesNotStart) {
  let_in("admin");
  const Host::Visit visit(lan_.host(0));
  fs::remove(file("trust/members/island-1/key.pem"));
  const auto ended = support::run_to_end({kIslandProgram, "run", file("home.yaml")});
  EXPECT_EQ(ended.code, 1) << ended.errors;
  EXPECT_THAT(ended.errors, AllOf(HasSubstr("key.pem"), Not(HasSubstr("is up"))));
}

TEST_F(TrustOnALan, AMemberWithoutRightsMayNothing) {
  let_in("guest");
  start_island();
  const auto commanded = person({"set", kLamp, "on"});
  EXPECT_NE(commanded.code, 0) << commanded.output << island_->errors();
  const auto value = person({"get", kLamp});
  EXPECT_EQ(value.code, 8) << value.errors << island_->errors();
}

}  // namespace
}  // namespace rubicon::ecology
