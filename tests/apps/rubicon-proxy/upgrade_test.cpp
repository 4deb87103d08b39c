#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "sqlite/database.h"
#include "state/state_support.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Configurations and a state file of the release before trust (tests/cases/upgrade), opened by this one.
class Upgrade : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    for (const auto& one : fs::directory_iterator(kCases))
      fs::copy_file(one.path(), folder_ / one.path().filename().string());
    auto file = sqlite::Database::open("state file", state_, sqlite::Database::Mode::kCreate);
    ASSERT_TRUE(file) << file.error().text;
    const auto made = file->run(state::read_all(folder_ / "state.sql").c_str(), "making it");
    ASSERT_TRUE(made) << made.error().text;
  }
  static std::vector<std::string> with(const std::string& trust, std::vector<std::string> words) {
    words.insert(words.begin(), {"env", "RUBICON_TRUST=" + trust, kDaemon});
    return words;
  }
  Outcome check(const std::string& name, const std::string& trust) const {
    return run_to_end(with(trust, {"check", "--elsewhere", folder_ / name}));
  }
  /// Repeats a question until its answer has this text: devices join one after the other. False after a minute.
  static bool says(Process& shell, const std::string& question, const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline) {
      shell.write(question + "\n");
      const auto line = shell.line_with("\"ok\"");
      if (!line) return false;
      if (line->find(text) != line->npos) return true;
    }
    return false;
  }
  std::string exported() const { return run_to_end(with("no", {"state", state_, "export"})).output; }

  static constexpr const char* kCases = RUBICON_SOURCE_DIR "/tests/cases/upgrade";
  PrivateNetwork alone_;
  Folder folder_;
  const std::string state_ = folder_ / "home.state";
};

TEST_F(Upgrade, AStateFileHoldsWhatItHeld) {
  EXPECT_EQ(exported(), state::read_all(folder_ / "state.jsonl"));
}

TEST_F(Upgrade, AnIslandKeepsNamesDecisionsAndWhatItsUserSet) {
  Process island(with("no", {"run", folder_ / "home.yaml", "--shell"}));
  EXPECT_TRUE(says(island, "inbox", R"("count":1,"ignored":1)"));
  for (const auto* text : {"Old room", "Ground floor"})
    EXPECT_TRUE(says(island, "get proxy.dummy-1.living.description", text)) << text;
  EXPECT_TRUE(says(island, "get proxy.dummy-1.living.property.rate.value", R"("value":"2000")"));
  island.write("quit\n");
  EXPECT_EQ(island.exit_code(), 0) << island.errors();
  const auto held = exported();
  EXPECT_THAT(held, AllOf(HasSubstr(R"("given-name":"Old room")"), HasSubstr(R"("decision":"ignored")"),
                          HasSubstr(R"("first-seen-us":1795719310734268)")));
}

TEST_F(Upgrade, ConfigurationsMeanWhatTheyMeantWithoutCertificates) {
  for (const auto* name : {"home.yaml", "lan.yaml", "carry.yaml"}) {
    const auto checked = check(name, "no");
    EXPECT_EQ(checked.code, 0) << name << "\n" << checked.errors;
    EXPECT_EQ(checked.errors, "") << name;
  }
}

/// tests/ecology has islands on a LAN, and looks at their sockets.
TEST_F(Upgrade, WhereThereWereCertificatesForDdsACheckSaysWhatToChoose) {
  for (const auto* name : {"home.yaml", "lan.yaml", "carry.yaml"}) {
    const auto checked = check(name, folder_ / "trust");
    EXPECT_EQ(checked.code, 0) << name << "\n" << checked.errors;
    EXPECT_THAT(checked.errors, AllOf(HasSubstr("warning: RUBICON_TRUST: this island had certificates for DDS"),
                                      HasSubstr("warning: choose: a broker with a realm")))
        << name;
  }
}

TEST_F(Upgrade, WhereThereWereCertificatesThePageWithoutTokensStaysClosedAndAWarningSaysSo) {
  Process island(with(folder_ / "trust", {"run", folder_ / "home.yaml", "--shell"}));
  EXPECT_TRUE(says(island, "inbox", R"("count":1,"ignored":1)"));
  island.write("quit\n");
  EXPECT_EQ(island.exit_code(), 0);
  EXPECT_THAT(island.errors(), AllOf(HasSubstr("warning web: "), HasSubstr("tokens")));
}

}  // namespace
}  // namespace rubicon::daemon
