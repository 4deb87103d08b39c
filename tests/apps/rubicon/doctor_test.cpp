#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <csignal>
#include <vector>

#include "apps/rubicon/doctor/island_look.h"
#include "apps/rubicon/live_island.h"
#include "tuples/dds/rogue.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;

/// What a line of `rubicon doctor --json` says.
struct Told {
  int code = 0;
  std::vector<nlohmann::json> lines;
  std::string everything;

  /// `check: what (mend)` of each.
  std::vector<std::string> problems() const {
    std::vector<std::string> all;
    for (const auto& line : lines) {
      if (line.value("grade", "") == "problem")
        all.push_back(line.value("check", "") + ": " + line.value("what", "") + " (" + line.value("mend", "") + ")");
    }
    return all;
  }
  /// The first one; empty = none.
  std::string problem() const {
    const auto all = problems();
    return all.empty() ? "" : all.front();
  }
};

/// Each in a network of its own, with one fault.
class Doctor : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  /// By DDS too.
  static Told ask(std::vector<std::string> more = {}) {
    if (std::find(more.begin(), more.end(), "--interfaces") == more.end())
      more.insert(more.end(), {"--interfaces", "lo"});
    return ask_host(std::move(more));
  }
  static Told ask_host(std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"doctor", "--json"});
    const auto outcome = rubicon(std::move(more));
    return {outcome.code, lines_of(outcome), outcome.output + outcome.errors};
  }
  static bool ip(std::vector<std::string> words, const std::string& program = "ip") {
    words.insert(words.begin(), program);
    return support::run_to_end(std::move(words)).code == 0;
  }

  PrivateNetwork alone_;
  Folder folder_;
};

TEST_F(Doctor, FindsNothingWrongWhereAllIsWell) {
  const auto island = started(folder_.write("a.yaml", small_island(5)), {"--set", "tuples.engine=dds"});
  const auto told = ask();
  EXPECT_EQ(told.code, 0) << told.everything;
  EXPECT_THAT(told.everything, HasSubstr("island 5"));
  const auto text = rubicon({"doctor", "--interfaces", "lo"});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.output, HasSubstr("good     firewall"));
  EXPECT_THAT(text.output, HasSubstr("nothing is wrong"));
  const auto full = support::run_to_end({"sh", "-c", kProgram + " doctor >/dev/full"});
  EXPECT_EQ(full.code, 1);
  EXPECT_THAT(full.errors, HasSubstr("rubicon: standard output: "));
}

TEST_F(Doctor, LooksAtAnIslandThatStartsMeanwhile) {
  auto client = Client::open();
  ASSERT_TRUE(client) << client.error().text;
  IslandLook look(**client, std::chrono::seconds(30));
  look.first();
  const auto island = started(folder_.write("a.yaml", small_island(5)), {"--set", "tuples.engine=dds"});
  (*client)->run_until([&] { return !(*client)->islands().empty(); }, std::chrono::seconds(30));
  const auto seen = look.second();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].island.id, OwnerId(5));
  EXPECT_TRUE(seen[0].answers);
  EXPECT_FALSE(seen[0].known_before);
  EXPECT_FALSE(seen[0].now.empty());
}

TEST_F(Doctor, KnowsWhatAnIslandHadLostBefore) {
  const auto island = started(folder_.write("a.yaml", small_island(5)), {"--set", "tuples.engine=dds"});
  auto client = Client::open();
  ASSERT_TRUE(client) << client.error().text;
  (*client)->run_until([&] { return !(*client)->islands().empty(); }, std::chrono::seconds(30));
  bool told = false;
  (*client)->send(OwnerId(5), "nobody-waits", "x", [&told](auto&&...) { told = true; });
  ASSERT_TRUE((*client)->run_until([&] { return told; }, std::chrono::seconds(30)));
  IslandLook look(**client, std::chrono::seconds(30));
  look.first();
  const auto seen = look.second();
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_TRUE(seen[0].known_before);
  EXPECT_EQ(seen[0].numbers_before.at("gateway-undeliverable"), 1U);
}

TEST_F(Doctor, NamesTheAbsenceOfIslands) {
  const auto told = ask();
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), testing::ContainsRegex("islands: no island in folder .* and domain 0 on lo .start one"));
  const auto here = ask_host();
  EXPECT_EQ(here.code, 1);
  EXPECT_THAT(here.problem(), testing::ContainsRegex("islands: no island in folder [^ ]* .start one"));
}

TEST_F(Doctor, OnAHostNamesWhoHangsAndWhoUsesDds) {
  const auto hung = started(folder_.write("a.yaml", small_island(5)));
  hung->signal(SIGSTOP);
  const auto told = ask_host();
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), HasSubstr("folder: pid " + std::to_string(hung->pid()) + " of uid"));
  hung->signal(SIGCONT);
  const auto distant = started(folder_.write("b.yaml", small_island(6, "{engine: dds, host: no}")));
  hung->signal(SIGKILL);
  const auto lonely = ask_host();
  EXPECT_THAT(lonely.everything, HasSubstr("1 program of this host use DDS in domain 0"));
}

TEST_F(Doctor, NamesTheFolderToo_WhereTheBrokerIsNotReached) {
  const auto open_to_all = folder_.file("meeting");
  std::filesystem::create_directories(open_to_all);
  std::filesystem::permissions(open_to_all, std::filesystem::perms::all);
  const auto told = ask_host({"--broker", "127.0.0.1:1", "--folder", open_to_all});
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problems(), testing::ElementsAre(HasSubstr("broker: "), HasSubstr("engine: " + open_to_all)))
      << told.everything;
}

TEST_F(Doctor, NamesAnInterfaceWithoutMulticast) {
  if (!ip({"link", "add", "one", "type", "veth", "peer", "name", "two"})) GTEST_SKIP() << "no veth pair can be made";
  ASSERT_TRUE(ip({"link", "set", "one", "multicast", "off"}));
  ASSERT_TRUE(ip({"address", "add", "10.1.0.1/24", "dev", "one"}));
  ASSERT_TRUE(ip({"link", "set", "two", "up"}) && ip({"link", "set", "one", "up"}));
  const auto told = ask({"--interfaces", "one"});
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), HasSubstr("no-multicast: one (10.1.0.1) has no multicast"));
  EXPECT_THAT(told.problem(), HasSubstr("ip link set one multicast on"));
}

TEST_F(Doctor, NamesTheDomainInWhichTheIslandsAre) {
  const auto island = started(folder_.write("a.yaml", small_island(5, "{engine: dds, host: no, domain: 17}")));
  const auto told = ask();
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), HasSubstr("other-domain: island 5"));
  EXPECT_THAT(told.problem(), HasSubstr("--domain 17"));
}

TEST_F(Doctor, NamesAPeerThatARuleKeepsOut) {
  if (!ip({"route", "add", "blackhole", "10.9.9.9/32"})) GTEST_SKIP() << "no routes can be made";
  if (!ip({"link", "add", "one", "type", "veth", "peer", "name", "two"})) GTEST_SKIP() << "no veth pair can be made";
  ASSERT_TRUE(ip({"address", "add", "10.1.0.1/24", "dev", "one"}));
  ASSERT_TRUE(ip({"link", "set", "two", "up"}) && ip({"link", "set", "one", "up"}));
  const auto refused = ask({"--interfaces", "one", "--peers", "10.9.9.9"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.problem(), HasSubstr("firewall: cannot send to peer 10.9.9.9"));
  const auto silent = ask({"--interfaces", "one", "--peers", "10.1.0.77"});
  EXPECT_THAT(silent.problem(), HasSubstr("firewall: peer 10.1.0.77 does not answer to UDP"));
}

TEST_F(Doctor, NamesAFirewallOfThisHost) {
  if (!ip({"qdisc", "replace", "dev", "lo", "root", "blackhole"}, "tc")) GTEST_SKIP() << "no packets can be dropped";
  const auto told = ask();
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), HasSubstr("firewall: UDP from lo to itself (127.0.0.1) does not arrive"));
}

TEST_F(Doctor, NamesAnIdThatIsTakenTwice) {
  const auto island = started(folder_.write("a.yaml", small_island(5)), {"--set", "tuples.engine=dds"});
  const tuples::dds::Rogue twin(5);  // unlike a daemon it does not go
  const auto told = ask({"--patience", "2s"});
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), HasSubstr("island-twice: id 5 is used by 2 programs"));
}

TEST_F(Doctor, NamesAHostThatIsFull) {
  std::vector<int> sockets;
  for (int port = 7410; port < 7410 + 2 * 120; ++port) {
    sockets.push_back(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(static_cast<std::uint16_t>(port));
    ASSERT_EQ(::bind(sockets.back(), reinterpret_cast<const sockaddr*>(&where), sizeof where), 0);
  }
  const auto told = ask();
  for (const int one : sockets) ::close(one);
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(),
              HasSubstr("participant-index: all 120 participant indexes of this host in domain 0 are in use"));
}

TEST_F(Doctor, NamesAComponentOfAnotherVersion) {
  const auto island = started(folder_.write("a.yaml", small_island(5)), {"--set", "tuples.engine=dds"});
  const tuples::dds::Rogue stranger(70001, 99);
  const auto told = ask();
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.problem(), HasSubstr("version: component 70001"));
  EXPECT_THAT(told.problem(), HasSubstr("uses protocol version 99"));
}

}  // namespace
}  // namespace rubicon::cli
