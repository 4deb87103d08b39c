#include "ecology/lan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "support/conversation.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using support::parsed;
using support::Process;
using support::until;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

const std::string kDaemon = RUBICON_BINARY_DIR "/bin/rubicon-proxy";
const std::string kProbe = RUBICON_BINARY_DIR "/bin/ecology-probe";
constexpr const char* kValue = "1:proxy.dummy-1.hall.sensor.temperature-1.value";
constexpr const char* kSwitch = "1:proxy.dummy-1.hall.actuator.switch-1.command";

auto has_value(const std::string& value) {
  return [value](const json& tuple) { return tuple.value("ok", false) && tuple.value("value", "") == value; };
}
bool is_applied(const json& answer) {
  return answer.value("verdict", "") == "applied";
}
bool has_some_value(const json& tuple) {
  return tuple.value("ok", false) && !tuple.value("value", "").empty();
}

/// Waits until `peer` is reported as up or down; returns how long that took.
std::optional<Clock::duration> news(Process& probe, int peer, const std::string& event) {
  const auto start = Clock::now();
  if (!probe.line_with("{\"peer\":" + std::to_string(peer) + ",\"event\":\"" + event + "\"")) return std::nullopt;
  return Clock::now() - start;
}

/// Sets until it is applied; the peer must not be lost meanwhile.
testing::AssertionResult applied_without_loss(Process& probe, const std::string& command, int peer) {
  const auto lost = "{\"peer\":" + std::to_string(peer) + ",\"event\":\"lost\"";
  for (const auto end = Clock::now() + 60s; Clock::now() < end;) {
    probe.write(command + "\n");
    auto line = probe.line();
    for (; line && line->find("\"ok\"") == line->npos; line = probe.line()) {
      if (line->starts_with(lost)) return testing::AssertionFailure() << *line;
    }
    if (!line) return testing::AssertionFailure() << "no answer to " << command;
    if (is_applied(parsed(line))) return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << command << " was not applied";
}

/// Waits until a probe sees this number of peers.
bool sees(Process& probe, std::size_t others) {
  return probe.line_with("\"there\":" + std::to_string(others) + "}").has_value();
}

/// Programs on hosts that are connected to one switch.
class OnALan : public testing::Test {
 protected:
  OnALan() {
    directory_ = std::filesystem::path(testing::TempDir()) /
                 ("rubicon_lan_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(directory_);
  }
  ~OnALan() override { std::filesystem::remove_all(directory_); }

  void connect(int hosts) {
    lan_ = std::make_unique<Lan>(hosts);
    if (!lan_->made()) GTEST_SKIP() << lan_->reason();
  }

  std::unique_ptr<Process> island(int host, int id, const std::string& tuples) const {
    const auto file = (directory_ / (std::to_string(id) + ".yaml")).string();
    std::ofstream(file, std::ios::binary) << "island: {id: " << id << ", name: island}\ntuples: " << tuples
                                          << "\nnetworks:\n  dummy-1: {type: dummy, simulate: {hall: {sensors: "
                                             "{temperature-1: {wave: sine, low: 10, high: "
                                             "30, period: 5s}}, actuators: {switch-1: {}}}}}\n";
    const Host::Visit there(lan_->host(host));
    return std::make_unique<Process>(std::vector<std::string>{kDaemon, "run", file, "--shell"});
  }
  std::unique_ptr<Process> probe(int host, int id, const std::string& tuples) const {
    const Host::Visit there(lan_->host(host));
    return std::make_unique<Process>(std::vector<std::string>{kProbe, std::to_string(id), tuples});
  }
  support::Outcome attempt(int host, const std::string& tuples) const {
    const Host::Visit there(lan_->host(host));
    return support::run_to_end({kProbe, "70000", tuples});
  }

  /// Required of each LAN configuration: the second island reads the first one's sensors, and commands it once it is
  /// trusted.
  void expect_reading_and_trust(const std::string& first_tuples, const std::string& second_tuples) const {
    auto second = island(1, 2, "{" + second_tuples + "}");
    {
      auto first = island(0, 1, "{" + first_tuples + "}");
      ASSERT_TRUE(ask(*second, std::string("subscribe ") + kValue + " min=50ms").value("ok", false));
      EXPECT_TRUE(until(*second, std::string("get ") + kValue, 60s, has_some_value)) << first->errors();
      const auto refused = ask(*second, std::string("set ") + kSwitch + " on");
      EXPECT_EQ(refused.value("verdict", ""), "refused") << refused;
      EXPECT_THAT(refused.dump(), HasSubstr("no remote sets from other hosts (its tuples.trust_lan is no)"));
      EXPECT_EQ(ask(*second, std::string("set ") + kSwitch + " on").value("verdict", ""), "refused");
      EXPECT_EQ(ask(*first, std::string("set ") + kSwitch + " off").value("verdict", ""), "applied") << "of this host";
      EXPECT_TRUE(until(*first, "get proxy.property.tuples-refused.value", 60s, has_value("2")));
      first->write("quit\n");
      EXPECT_EQ(first->exit_code(), 0);
      const auto said = first->errors();
      const auto once = said.find("are refused: it runs on another host");
      ASSERT_NE(once, said.npos) << said;
      EXPECT_EQ(said.find("are refused: it runs on another host", once + 1), said.npos) << said;
    }
    auto first = island(0, 1, "{" + first_tuples + ", trust_lan: yes}");
    EXPECT_TRUE(until(*second, std::string("set ") + kSwitch + " on", 60s, is_applied));
    EXPECT_TRUE(
        until(*first, std::string("get ") + "proxy.dummy-1.hall.actuator.switch-1.value", 60s, has_value("on")));
  }

  std::filesystem::path directory_;
  std::unique_ptr<Lan> lan_;
};

TEST_F(OnALan, WithMulticastNamingTheInterfaceIsEnough) {
  connect(2);
  if (IsSkipped()) return;
  expect_reading_and_trust("interfaces: cable", "interfaces: [cable]");
}

TEST_F(OnALan, WithoutMulticastOneListOfHostsIsEnough) {
  connect(2);
  if (IsSkipped()) return;
  for (const int host : {0, 1}) lan_->interface_without_multicast(host);
  EXPECT_THAT(attempt(0, "{interfaces: cable}").errors,
              HasSubstr("interface 'cable' has no multicast: name the other hosts in tuples.peers"));
  const auto peers = "interfaces: cable, peers: [" + Lan::address(0) + ", " + Lan::address(1) + "]";
  expect_reading_and_trust(peers, peers);
}

TEST_F(OnALan, OverTcpHostsAndPortsAreNamed) {
  connect(2);
  if (IsSkipped()) return;
  for (const int host : {0, 1}) lan_->interface_without_multicast(host);
  // Cyclone's threads keep TCP connections until the process ends; a sanitizer would report them as leaks of ours.
  ::setenv("LSAN_OPTIONS", "detect_leaks=0", 1);
  const auto peers = ", peers: [\"" + Lan::address(0) + ":7500\", \"" + Lan::address(1) + ":7500\"]";
  expect_reading_and_trust("interfaces: cable, transport: tcp, port: 7500" + peers,
                           "interfaces: cable, transport: tcp, port: 7500" + peers);
  ::unsetenv("LSAN_OPTIONS");
}

TEST_F(OnALan, MessagesToTheGatewayOfAnotherHostNeedTrustToo) {
  connect(2);
  if (IsSkipped()) return;
  auto first = island(0, 1, "{interfaces: cable}");
  auto second = probe(1, 70'000, "{interfaces: cable}");
  ASSERT_TRUE(news(*second, 1, "up"));
  const auto answer = ask(*second, "set 1:GATEWAY x");
  EXPECT_EQ(answer.value("verdict", ""), "refused") << answer;
  EXPECT_THAT(answer.dump(), HasSubstr("trust_lan"));
}

TEST_F(OnALan, LoopbackStaysOnItsHost) {
  connect(2);
  if (IsSkipped()) return;
  const auto sent = lan_->host(0).packets_sent(Lan::kCable);
  auto inside = probe(0, 70'001, "{}");
  auto beside = probe(0, 70'002, "{}");
  ASSERT_TRUE(news(*inside, 70'002, "up"));
  ASSERT_TRUE(news(*beside, 70'001, "up"));
  ASSERT_TRUE(ask(*beside, "subscribe 70001:probe.**").value("ok", false));
  EXPECT_TRUE(until(*beside, "set 70001:probe.x 5", 60s, is_applied));
  EXPECT_TRUE(until(*beside, "get 70001:probe.x", 60s, has_value("5")));
  EXPECT_EQ(lan_->host(0).packets_sent(Lan::kCable), sent) << "nothing leaves the host";
  // Components outside find each other, but not these.
  auto outside = probe(1, 70'003, "{interfaces: cable, peers: " + Lan::address(0) + "}");
  auto companion = probe(1, 70'004, "{interfaces: cable, peers: " + Lan::address(0) + "}");
  ASSERT_TRUE(news(*outside, 70'004, "up"));
  std::this_thread::sleep_for(4s);  // two announcements
  EXPECT_EQ(ask(*outside, "set 70001:probe.x 6").value("verdict", ""), "no-such-owner");
  EXPECT_EQ(ask(*inside, "set 70003:probe.x 6").value("verdict", ""), "no-such-owner");
}

TEST_F(OnALan, OtherDomainsAndTagsAreNotSeen) {
  connect(2);
  if (IsSkipped()) return;
  auto one = probe(0, 70'001, "{interfaces: cable}");
  auto tagged = probe(1, 70'002, "{interfaces: cable, tag: other}");
  auto elsewhere = probe(1, 70'003, "{interfaces: cable, domain: 5}");
  auto same = probe(1, 70'004, "{interfaces: cable}");
  auto tagged_too = probe(0, 70'005, "{interfaces: cable, tag: other}");
  ASSERT_TRUE(news(*one, 70'004, "up"));
  ASSERT_TRUE(news(*tagged, 70'005, "up"));
  std::this_thread::sleep_for(4s);  // two announcements
  for (const auto* stranger : {"70002", "70003"})
    EXPECT_EQ(ask(*one, std::string("set ") + stranger + ":probe.x 1").value("verdict", ""), "no-such-owner");
  EXPECT_EQ(ask(*tagged, "set 70001:probe.x 1").value("verdict", ""), "no-such-owner");
}

/// An owner and a subscriber on two hosts with a connection that breaks.
class ABreak : public OnALan {
 protected:
  void watch(const std::string& more) {
    connect(2);
    if (IsSkipped()) return;
    owner_ = probe(0, 70'001, "{interfaces: cable, lease: 1s, trust_lan: yes" + more + "}");
    subscriber_ = probe(1, 70'002, "{interfaces: cable, lease: 1s, trust_lan: yes" + more + "}");
    ASSERT_TRUE(news(*owner_, 70'002, "up"));
    ASSERT_TRUE(news(*subscriber_, 70'001, "up"));
    ASSERT_EQ(ask(*owner_, "set probe.x before").value("verdict", ""), "applied");
    ASSERT_TRUE(ask(*subscriber_, "subscribe 70001:probe.**").value("ok", false));
    ASSERT_TRUE(until(*subscriber_, "get 70001:probe.x", 60s, has_value("before")));
  }
  void expect_loss() {
    const auto start = Clock::now();
    EXPECT_TRUE(news(*subscriber_, 70'001, "lost"));
    EXPECT_TRUE(news(*owner_, 70'002, "lost"));
    EXPECT_LT(Clock::now() - start, 30s) << "the lease is a second";
    EXPECT_TRUE(has_value("before")(ask(*subscriber_, "get 70001:probe.x"))) << "stays readable";
    EXPECT_EQ(ask(*owner_, "set probe.x after").value("verdict", ""), "applied") << "unseen by the other";
    std::this_thread::sleep_until(start + 5s);  // the break lasts longer than several leases
  }
  void expect_convergence() {
    const auto start = Clock::now();
    EXPECT_TRUE(news(*subscriber_, 70'001, "up"));
    EXPECT_TRUE(until(*subscriber_, "get 70001:probe.x", 60s, has_value("after")));
    EXPECT_TRUE(news(*owner_, 70'002, "up"));
    EXPECT_TRUE(until(*subscriber_, "set 70001:probe.x final", 60s, is_applied));
    EXPECT_TRUE(until(*subscriber_, "get 70001:probe.x", 60s, has_value("final")));
    RecordProperty("milliseconds_to_converge", static_cast<int>((Clock::now() - start) / 1ms));
  }

  std::unique_ptr<Process> owner_, subscriber_;
};

TEST_F(ABreak, OfTheCableIsShownAndHeals) {
  watch("");
  if (IsSkipped() || HasFatalFailure()) return;
  for (int round = 0; round < 2 && !HasFailure(); ++round) {
    lan_->unplug(0);
    expect_loss();
    lan_->plug_in(0);
    expect_convergence();
    EXPECT_EQ(ask(*owner_, "set probe.x before").value("verdict", ""), "applied");
    EXPECT_TRUE(until(*subscriber_, "get 70001:probe.x", 60s, has_value("before")));
  }
}

TEST_F(ABreak, OfTheInterfaceIsShownAndHeals) {
  watch("");
  if (IsSkipped() || HasFatalFailure()) return;
  lan_->interface_down(0);
  expect_loss();
  lan_->interface_up(0);
  expect_convergence();
}

TEST_F(ABreak, BetweenListedHostsIsShownAndHeals) {
  watch(", peers: [" + Lan::address(0) + ", " + Lan::address(1) + "]");
  if (IsSkipped() || HasFatalFailure()) return;
  lan_->unplug(1);
  expect_loss();
  lan_->plug_in(1);
  expect_convergence();
}

TEST_F(ABreak, OverTcpIsShownAndHeals) {
  watch(", transport: tcp, port: 7500, peers: [\"" + Lan::address(0) + ":7500\", \"" + Lan::address(1) + ":7500\"]");
  if (IsSkipped() || HasFatalFailure()) return;
  lan_->unplug(1);
  expect_loss();
  lan_->plug_in(1);
  expect_convergence();
}

TEST_F(OnALan, OfTwoWithOneIdTheLaterOneEndsWhenTheCableIsMended) {
  connect(2);
  if (IsSkipped()) return;
  lan_->unplug(1);
  auto first = island(0, 1, "{interfaces: cable, lease: 1s}");
  ASSERT_TRUE(ask(*first, "get proxy.island").value("ok", false));
  std::filesystem::create_directories(directory_ /= "other");
  auto second = island(1, 1, "{interfaces: cable, lease: 1s}");
  ASSERT_TRUE(ask(*second, "get proxy.island").value("ok", false)) << "starting waits for nobody";
  lan_->plug_in(1);
  EXPECT_EQ(second->exit_code(), 1);
  EXPECT_THAT(second->errors(), HasSubstr("component id 1 is in use by another process"));
  EXPECT_TRUE(ask(*first, "get proxy.island").value("ok", false));
  directory_ = directory_.parent_path();
}

TEST_F(OnALan, ProgramsEndAfterTheAddressOfTheInterfaceChanged) {
  connect(1);
  if (IsSkipped()) return;
  auto here = island(0, 1, "{interfaces: cable, lease: 1s}");
  ASSERT_TRUE(ask(*here, "get proxy.island").value("ok", false));
  const Host::Visit visit(lan_->host(0));
  Process watch({RUBICON_BINARY_DIR "/bin/rubicon", "watch", "--interfaces", "cable", "1:**"});
  ASSERT_TRUE(watch.line());
  lan_->change_address(0, Lan::address(0), Lan::address(100));
  watch.signal(SIGINT);
  here->signal(SIGTERM);
  EXPECT_THAT(watch.exit_code(), AnyOf(0, 128 + SIGINT));
  EXPECT_EQ(here->exit_code(), 0) << here->errors();
}

TEST_F(OnALan, EachIsLostByItsOwnLease) {
  connect(1);
  if (IsSkipped()) return;
  auto patient = probe(0, 70'001, "{lease: 60s}");
  auto brief = probe(0, 70'002, "{lease: 500ms}");
  ASSERT_TRUE(news(*patient, 70'002, "up"));
  ASSERT_TRUE(news(*brief, 70'001, "up"));
  brief->signal(SIGKILL);
  const auto gone = news(*patient, 70'002, "lost");
  ASSERT_TRUE(gone);
  EXPECT_LT(*gone, 30s) << "its own lease is half a second, that of the other a minute";
  auto again = probe(0, 70'003, "{lease: 500ms}");
  ASSERT_TRUE(news(*again, 70'001, "up"));
  patient->signal(SIGSTOP);
  std::this_thread::sleep_for(2s);
  patient->signal(SIGCONT);
  EXPECT_TRUE(applied_without_loss(*again, "set 70001:probe.x 1", 70'001)) << "two seconds of sixty";
}

/// Sockets of a host for the network, whoever opened them.
int open_ports() {
  int count = 0;
  for (const std::string kind : {"udp", "udp6", "tcp", "tcp6"}) {
    std::ifstream file("/proc/thread-self/net/" + kind);
    std::string line;
    for (std::getline(file, line); std::getline(file, line);) ++count;
  }
  return count;
}

TEST_F(OnALan, AnIslandWithoutDdsHasNoPortForOthers) {
  connect(1);
  if (IsSkipped()) return;
  const auto ports = [&](const std::string& tuples) {
    const auto one = island(0, 1, tuples);
    EXPECT_EQ(ask(*one, "get proxy.dummy-1.hall.description").value("ok", false), true) << one->errors();
    const Host::Visit there(lan_->host(0));
    return open_ports();
  };
  EXPECT_EQ(ports("{}"), 0);
  EXPECT_GT(ports("{interfaces: [cable]}"), 0);
}

TEST_F(OnALan, TenIslandsSeeEachOther) {
  constexpr int kIslands = 10;
  connect(kIslands);
  if (IsSkipped()) return;
  const auto start = Clock::now();
  std::vector<std::unique_ptr<Process>> probes;
  for (int i = 0; i < kIslands; ++i) probes.push_back(probe(i, i + 1, "{interfaces: cable}"));
  for (auto& one : probes) EXPECT_TRUE(sees(*one, kIslands - 1));
  RecordProperty("milliseconds", static_cast<int>((Clock::now() - start) / 1ms));
}

TEST_F(OnALan, FiftyComponentsOfOneHostSeeEachOther) {
  constexpr int kComponents = 50;
  connect(1);
  if (IsSkipped()) return;
  const auto start = Clock::now();
  std::vector<std::unique_ptr<Process>> probes;
  for (int i = 0; i < kComponents; ++i) probes.push_back(probe(0, 70'000 + i, "{}"));
  for (auto& one : probes) EXPECT_TRUE(sees(*one, kComponents - 1));
  RecordProperty("milliseconds", static_cast<int>((Clock::now() - start) / 1ms));
}

}  // namespace
}  // namespace rubicon::ecology
