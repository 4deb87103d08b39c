#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "ecology/lan.h"
#include "support/conversation.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using support::Process;
using support::until;
using testing::HasSubstr;

/// A probe on each of two hosts, the address of the first one changes.
class Roams : public testing::Test {
 protected:
  void SetUp() override {
    if (!lan_.made()) GTEST_SKIP() << lan_.reason();
    one_ = probe(0, 70'001);
    other_ = probe(1, 70'002);
    for (auto* who : {one_.get(), other_.get()}) {
      ASSERT_TRUE(who->line_with("\"event\":\"up\""));
      ASSERT_TRUE(ask(*who, "subscribe *:probe.**").value("ok", false));
    }
  }

  std::unique_ptr<Process> probe(int host, int id) const {
    const Host::Visit there(lan_.host(host));
    return std::make_unique<Process>(std::vector<std::string>{
        RUBICON_BINARY_DIR "/bin/ecology-probe", std::to_string(id), "{interfaces: cable, lease: 1s, trust_lan: yes}"});
  }
  /// What one sets from now on, the other sees, and each carries out what the other asks for.
  void expect_both_hear(const std::string& value) const {
    for (const auto& [from, to, id] :
         {std::tuple(one_.get(), other_.get(), "70001:"), {other_.get(), one_.get(), "70002:"}}) {
      ASSERT_EQ(ask(*from, "set probe.own " + value).value("verdict", ""), "applied");
      ASSERT_TRUE(until(*to, std::string("get ") + id + "probe.own", 30s,
                        [&](const json& tuple) { return tuple.value("value", "") == value; }))
          << from->errors() << to->errors();
      ASSERT_TRUE(until(*to, std::string("set ") + id + "probe.asked " + value, 30s,
                        [](const json& answer) { return answer.value("verdict", "") == "applied"; }));
    }
  }
  void move_to(const std::string& address) { lan_.change_address(0, std::exchange(address_, address), address); }
  void expect_both_lose_and_meet() const {
    for (const auto* event : {"lost", "up"}) {
      for (auto* who : {one_.get(), other_.get()})
        ASSERT_TRUE(who->line_with(std::string("\"event\":\"") + event + "\"")) << one_->errors() << other_->errors();
    }
  }

  Lan lan_{2};
  std::string address_ = Lan::address(0);
  std::unique_ptr<Process> one_, other_;
};

TEST_F(Roams, TwentyTimesAndBothHearEachOther) {
  expect_both_hear("first");
  long memory = 0, descriptors = 0;
  for (int round = 0; round < 20; ++round) {
    move_to(Lan::address(100 + round));
    expect_both_lose_and_meet();
    expect_both_hear(std::to_string(round));
    if (HasFatalFailure()) return;
    if (round != 9) continue;
    memory = one_->resident_kilobytes();
    descriptors = one_->open_descriptors();
  }
  EXPECT_LT(one_->resident_kilobytes(), memory + 1000);
  EXPECT_LE(one_->open_descriptors(), descriptors + 20) << "a former domain may not be deleted yet";
  one_->signal(SIGTERM);
  EXPECT_EQ(one_->exit_code(), 128 + SIGTERM);
}

TEST_F(Roams, ThroughATimeWithoutAnAddress) {
  expect_both_hear("first");
  move_to("");
  ASSERT_TRUE(other_->line_with("\"event\":\"lost\""));
  move_to(Lan::address(100));
  ASSERT_TRUE(other_->line_with("\"event\":\"up\"")) << one_->errors();
  expect_both_hear("again");
  EXPECT_THAT(one_->errors(), HasSubstr("interface cable has no IPv4 address: it reaches no other host"));
  EXPECT_THAT(one_->errors(), HasSubstr("addresses changed: cable (10.77.0.101); before cable (10.77.0.1)"));
}

/// Kernels keep the address of an interface that is down.
TEST_F(Roams, ThroughATimeWithoutInterface) {
  expect_both_hear("first");
  lan_.interface_down(0);
  ASSERT_TRUE(other_->line_with("\"event\":\"lost\""));
  lan_.interface_up(0);
  ASSERT_TRUE(other_->line_with("\"event\":\"up\""));
  expect_both_hear("again");
  EXPECT_THAT(one_->errors(), HasSubstr("interface cable is down: it reaches no other host"));
  EXPECT_EQ(one_->errors().find("addresses changed"), std::string::npos) << "it goes on with what it has";
}

/// An island, and a tool on its host.
class RoamingIsland : public testing::Test {
 protected:
  void SetUp() override {
    if (!lan_.made()) GTEST_SKIP() << lan_.reason();
    const auto file = std::filesystem::path(testing::TempDir()) / "rubicon_roaming.yaml";
    std::ofstream(file) << "island: {id: 1, name: island}\ntuples: {interfaces: cable, lease: 1s, trust_lan: yes}\n"
                           "networks: {}\n";
    const Host::Visit there(lan_.host(0));
    island_ = std::make_unique<Process>(
        std::vector<std::string>{RUBICON_BINARY_DIR "/bin/rubicon-proxy", "run", file.string(), "--shell"});
    ASSERT_TRUE(ask(*island_, "get proxy.island").value("ok", false)) << island_->errors();
  }
  support::Outcome tool(std::vector<std::string> words) const {
    const Host::Visit there(lan_.host(0));
    words.insert(words.begin(), RUBICON_BINARY_DIR "/bin/rubicon");
    return support::run_to_end(words);
  }
  bool shows(const std::string& part) const {
    return until(*island_, "get proxy.property.dds-interfaces.value", 30s,
                 [&](const json& tuple) { return tuple.value("value", "").find(part) != std::string::npos; });
  }

  Lan lan_{2};
  std::unique_ptr<Process> island_;
};

TEST_F(RoamingIsland, SaysSoAndEnds) {
  ASSERT_TRUE(shows(R"("changes":0)"));
  lan_.change_address(0, Lan::address(0), "");
  ASSERT_TRUE(shows("has no IPv4 address"));
  EXPECT_THAT(tool({"doctor", "--for", "100ms"}).output,
              HasSubstr("interface cable of island 1 island has no IPv4 address: it reaches no other host"));
  lan_.change_address(0, "", Lan::address(5));
  ASSERT_TRUE(shows(R"("changes":1)"));
  EXPECT_THAT(tool({"doctor", "--for", "100ms"}).output, HasSubstr("the addresses of island 1 island changed 1 times"));
  const Host::Visit there(lan_.host(0));
  Process watch({RUBICON_BINARY_DIR "/bin/rubicon", "watch", "--interfaces", "cable", "1:**"});
  ASSERT_TRUE(watch.line());
  lan_.change_address(0, Lan::address(5), "");
  for (const auto* one : {&watch, island_.get()}) one->signal(SIGTERM);
  EXPECT_THAT(watch.exit_code(), testing::AnyOf(0, 128 + SIGTERM));
  EXPECT_EQ(island_->exit_code(), 0) << island_->errors();
}

}  // namespace
}  // namespace rubicon::ecology
