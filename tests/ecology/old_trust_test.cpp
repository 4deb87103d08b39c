#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <sstream>

#include "ecology/island_on_a_lan.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kNotByDds =
    "this island had certificates for DDS, which this release does not have: it does not take part by DDS";
constexpr const char* kChoose = "choose: a broker with a realm (docs/sites.md), or `tuples: {trust: no}`";

/// An installation of a release that had certificates for DDS, opened by this one: a folder as that release made it,
/// and a file that names it.
class OldTrust : public IslandOnALan {
 protected:
  void SetUp() override {
    IslandOnALan::SetUp();
    if (IsSkipped()) return;
    fs::create_directories(file("trust/members/island-1"));
    for (const auto* name : {"trust/identity-ca.pem", "trust/permissions-ca.pem", "trust/governance.p7s",
                             "trust/revoked.p7s", "trust/members/island-1/certificate.pem",
                             "trust/members/island-1/permissions.p7s", "trust/members/island-1/key.pem"})
      write(name, "of an earlier release\n");
  }
  void upgrade(const std::string& trust) const {
    configure("{interfaces: [cable], trust_lan: yes" + (trust.empty() ? "" : ", trust: " + trust) + "}");
  }
  static std::vector<std::string> with_variable(const std::string& value) { return {"env", "RUBICON_TRUST=" + value}; }

  /// UDP sockets of the island's host on ports of DDS (proc_net_udp: the local address is hexadecimal).
  int dds_sockets() const {
    std::ifstream table("/proc/" + std::to_string(island_->pid()) + "/net/udp");
    int found = 0;
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line)) {
      const auto colon = line.find(':', line.find(':') + 1);
      const auto port = std::stoul(line.substr(colon + 1, 4), nullptr, 16);
      if (port >= tuples::dds::multicast_port_of(0) && port < tuples::dds::multicast_port_of(1)) ++found;
    }
    return found;
  }
  void expect_held_back() const {
    EXPECT_EQ(dds_sockets(), 0);
    EXPECT_THAT(island_->errors(), AllOf(HasSubstr(kNotByDds), HasSubstr(kChoose)));
    const auto set = here({"set", "den.switch-1", "on"});
    EXPECT_EQ(set.code, 0) << set.errors << "its networks run, and the programs of its host reach it";
    EXPECT_NE(other({"get", part("value")}).code, 0) << "nobody else does";
    const auto doctor = here({"doctor", "--for", "100ms"});
    EXPECT_EQ(doctor.code, 1) << doctor.output;
    EXPECT_THAT(doctor.output, AllOf(HasSubstr("it does not take part by DDS"), HasSubstr("{trust: no}")));
    EXPECT_THAT(here({"alerts"}).output, HasSubstr("it does not take part by DDS"));
  }
  static std::string part(const std::string& name) { return kLamp + name; }
};

TEST_F(OldTrust, AnIslandThatHadItDoesNotTakePartByDds) {
  for (const std::string trust : {"./trust", "yes"}) {
    upgrade(trust);
    start_island();
    expect_held_back();
    const auto checked = support::run_to_end({kDaemonProgram, "check", file("home.yaml")});
    EXPECT_EQ(checked.code, 0) << checked.errors;
    EXPECT_THAT(checked.errors, AllOf(HasSubstr(std::string("warning: tuples.trust: ") + kNotByDds),
                                      HasSubstr(std::string("warning: ") + kChoose)));
    island_.reset();
  }
}

TEST_F(OldTrust, AnIslandThatHadItByTheEnvironmentDoesNotEither) {
  upgrade("");
  start_island(with_variable(file("trust")));
  expect_held_back();
}

/// As a package of that release made it: a folder that nobody names. What cannot be looked at counts too.
TEST_F(OldTrust, AnIslandOfAHostWithTheFolderDoesNotEither) {
  const std::pair<std::string, std::string> traces[] = {
      {"mkdir -p /etc/rubicon/trust", "/etc/rubicon/trust: "},
      {"mkdir /etc/rubicon && touch /etc/rubicon/trust.realm", "/etc/rubicon/trust.realm: "},
      {"ln -s rubicon /etc/rubicon", "/etc/rubicon/trust: "}};
  for (const auto& [make, place] : traces) {
    const auto mounted = "mount -t tmpfs -o mode=755 etc /etc && " + make + " && exec \"$@\"";
    const std::vector<std::string> before{"env", "-u", "RUBICON_TRUST", "unshare", "--mount",
                                          "sh",  "-c", mounted,         "sh"};
    auto probe = before;
    probe.insert(probe.end(), {"ls", "/etc"});
    if (const auto made = support::run_to_end(probe); made.output != "rubicon\n")
      GTEST_SKIP() << "no file system in a private mount namespace: " << made.errors;
    upgrade("");
    start_island(before);
    EXPECT_EQ(dds_sockets(), 0) << make;
    EXPECT_THAT(island_->errors(), HasSubstr(place + kNotByDds)) << make;
    island_.reset();
  }
}

/// What asked for certificates before is no more open than it was, on its host neither.
TEST_F(OldTrust, ThePageOfSuchAnIslandNeedsTokens) {
  configure("{trust: yes}", "web: {}\n");
  start_island();
  EXPECT_THAT(island_->errors(), HasSubstr("each caller needs a token"));
  EXPECT_THAT(island_->errors(), HasSubstr("and the island is not on DDS: remove this key"));
}

TEST_F(OldTrust, WhoWritesThatItWantsNoneIsOnDds) {
  upgrade("no");
  start_island(with_variable(file("trust")));
  EXPECT_GT(dds_sockets(), 0);
  EXPECT_THAT(island_->errors(),
              AllOf(Not(HasSubstr(kNotByDds)), HasSubstr("anybody who reaches its interfaces may command it")));
  const auto set = other({"set", part("command"), "on"});
  EXPECT_EQ(set.code, 0) << set.errors;
}

TEST_F(OldTrust, AnIslandThatNeverHadItIsOnDds) {
  upgrade("");
  start_island(with_variable("no"));
  EXPECT_GT(dds_sockets(), 0);
}

/// What `systemctl status` shows.
TEST_F(OldTrust, TheServiceManagerIsToldToo) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto path = file("notify");
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(::bind(manager, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  upgrade("./trust");
  start_island({"env", "NOTIFY_SOCKET=" + path});
  std::array<char, 4096> notice{};
  const auto size = ::recv(manager, notice.data(), notice.size(), 0);
  ASSERT_GT(size, 0);
  EXPECT_THAT(std::string(notice.data(), static_cast<std::size_t>(size)),
              AllOf(HasSubstr("STATUS=island 1 (home) is up: 1 network; "), HasSubstr(kNotByDds), HasSubstr(kChoose)));
  ::close(manager);
}

TEST_F(OldTrust, OldWordsOfTheCommandLineAreAnsweredWithTheNewThing) {
  for (const auto& words : std::vector<std::vector<std::string>>{{"trust", "dds", "init"},
                                                                 {"trust", "request", "robot"},
                                                                 {"trust", "sign", "robot.csr"},
                                                                 {"trust", "export", "x"}}) {
    const auto told = here(words);
    EXPECT_EQ(told.code, 2) << words[1];
    EXPECT_THAT(told.errors, HasSubstr("meet at a broker with a realm (docs/sites.md)")) << words[1];
  }
  EXPECT_EQ(other({"islands", "--trust", "no"}).code, other({"islands"}).code);
  const auto option = other({"islands", "--trust", file("trust")});
  EXPECT_EQ(option.code, 2);
  EXPECT_THAT(option.errors, HasSubstr("--trust: this release has no certificates for DDS"));
  const auto variable = start(1, {"env", "RUBICON_TRUST=" + file("trust"), kToolProgram, "islands", "--engine", "dds"});
  EXPECT_EQ(variable->exit_code(), 2);
  EXPECT_THAT(variable->errors(), HasSubstr("RUBICON_TRUST: this release has no certificates for DDS"));
}

}  // namespace
}  // namespace rubicon::ecology
