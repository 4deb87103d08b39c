#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <sstream>

#include "install/installed.h"
#include "install/notice_socket.h"
#include "support/private_network.h"

namespace rubicon::install {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;

/// The installed unit, and the daemon as its command line starts it.
class Unit : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(all_.outcome().code, 0) << all_.outcome().output << all_.outcome().errors;
    ASSERT_FALSE(manager_.path().empty());
  }

  /// The words of a setting, for the island `home`.
  std::vector<std::string> words(const std::string& setting) const {
    std::istringstream lines(read_text(unit_));
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with(setting + "=")) continue;
      std::istringstream rest(line.substr(setting.size() + 1));
      for (std::string word; rest >> word;) {
        if (const auto at = word.find("%i"); at != word.npos) word.replace(at, 2, "home");
        found.push_back(word);
      }
    }
    return found;
  }
  /// What the service manager would start; the watchdog is shorter than the unit's, for the tests to be.
  std::vector<std::string> started(const std::string& watchdog_microseconds = "200000") const {
    std::vector<std::string> command{"env", "NOTIFY_SOCKET=" + manager_.path(),
                                     "WATCHDOG_USEC=" + watchdog_microseconds};
    for (auto& word : words("ExecStart")) command.push_back(std::move(word));
    return command;
  }

  const Installed& all_ = Installed::get();
  const std::filesystem::path unit_ = all_.prefix() / "lib/systemd/system/rubicon-proxy@.service";
  const std::filesystem::path island_ = all_.prefix() / "etc/rubicon/home.yaml";
  support::PrivateNetwork alone_;
  NoticeSocket manager_{(all_.workshop() / "notify").string()};
};

TEST_F(Unit, StartsOneIslandEachFromItsOwnFile) {
  const auto command = words("ExecStart");
  ASSERT_EQ(command.size(), 3U);
  EXPECT_EQ(command[0], all_.daemon());
  EXPECT_EQ(command[2], island_.string());
  EXPECT_EQ(words("Type"), std::vector<std::string>{"notify"});
  EXPECT_EQ(words("WantedBy"), std::vector<std::string>{"multi-user.target"});
}

TEST_F(Unit, IsWhatSystemdUnderstands) {
  if (all_.shell("command -v systemd-analyze").code != 0) GTEST_SKIP() << "there is no systemd here";
  const auto verified = all_.shell("systemd-analyze verify --man=no " + unit_.string());
  EXPECT_EQ(verified.code, 0);
  EXPECT_EQ(verified.output, "");  // unknown settings are told, and ignored
}

TEST_F(Unit, HasABoundForItsMemory) {
  EXPECT_EQ(words("MemoryMax"), std::vector<std::string>{"1G"});
}

TEST_F(Unit, IsLittleExposed) {
  if (all_.shell("command -v systemd-analyze").code != 0) GTEST_SKIP() << "there is no systemd here";
  for (const auto* unit : {"rubicon-proxy@.service", "rubicon-broker@.service"}) {
    const auto judged = all_.shell("systemd-analyze security --no-pager --offline=true --threshold=16 " +
                                   (unit_.parent_path() / unit).string());
    EXPECT_EQ(judged.code, 0) << judged.output;
    EXPECT_THAT(judged.output, HasSubstr("Overall exposure level"));
  }
}

/// The unit of a broker, setting by setting.
TEST_F(Unit, OfABrokerRunsAMosquittoAsAUserOfItsOwn) {
  const auto unit = read_text(unit_.parent_path() / "rubicon-broker@.service");
  for (const auto* line :
       {"Type=notify", "ExecStart=/usr/sbin/mosquitto -c /etc/rubicon/broker/%i/mosquitto.conf",
        "ExecReload=/bin/kill -HUP $MAINPID", "ConditionPathExists=/etc/rubicon/broker/%i/mosquitto.conf",
        "User=rubicon-broker", "Group=rubicon-broker", "StateDirectory=rubicon-broker/%i", "StateDirectoryMode=0700",
        "Restart=on-failure", "TimeoutStopSec=30s", "LimitCORE=0", "MemoryMax=1G",
        "CapabilityBoundingSet=", "NoNewPrivileges=yes", "ProtectSystem=strict", "ProtectHome=yes",
        "PrivateDevices=yes", "RestrictAddressFamilies=AF_INET AF_INET6 AF_UNIX", "WantedBy=multi-user.target"})
    EXPECT_THAT(unit, HasSubstr("\n" + std::string(line) + "\n"));
  EXPECT_THAT(read_text(all_.prefix() / "lib/sysusers.d/rubicon.conf"), HasSubstr("\nu rubicon-broker - "));
  if (all_.shell("command -v systemd-analyze && test -x /usr/sbin/mosquitto").code != 0) return;
  const auto verified =
      all_.shell("systemd-analyze verify --man=no " + (unit_.parent_path() / "rubicon-broker@.service").string());
  EXPECT_EQ(verified.output, "");
}

/// Of releases that had certificates for DDS.
TEST_F(Unit, NeedsNoKeysAndWritesNoneToACoreFile) {
  for (const auto* setting : {"Requires", "LoadCredential", "SetCredential"})
    EXPECT_THAT(words(setting), testing::IsEmpty()) << setting;
  EXPECT_FALSE(std::filesystem::exists(unit_.parent_path() / "rubicon-trust@.service"));
  EXPECT_EQ(words("LimitCORE"), std::vector<std::string>{"0"});
}

/// Of all users of the host, and of no unit alone.
TEST_F(Unit, MeetsOthersInTheFolderOfTheHost) {
  EXPECT_EQ(words("User"), std::vector<std::string>{"rubicon"});
  EXPECT_EQ(words("Group"), std::vector<std::string>{"rubicon"});
  EXPECT_THAT(words("Environment"), testing::Contains("RUBICON_FOLDER=/run/rubicon"));
  EXPECT_EQ(words("ReadWritePaths"), std::vector<std::string>{"-/run/rubicon"});
  EXPECT_EQ(words("ExecStartPre"),
            (std::vector<std::string>{"+/bin/systemd-tmpfiles", "--create",
                                      (all_.prefix() / "lib/tmpfiles.d/rubicon.conf").string()}));
  for (const auto* setting : {"DynamicUser", "PrivateUsers", "RuntimeDirectory"})
    EXPECT_THAT(words(setting), testing::IsEmpty()) << setting;
  const auto folders = read_text(all_.prefix() / "lib/tmpfiles.d/rubicon.conf");
  EXPECT_THAT(folders, HasSubstr("\nd /run/rubicon 0750 root rubicon\n"));
  EXPECT_THAT(folders, HasSubstr("\nd /run/rubicon/islands 2750 rubicon rubicon\n"));
  EXPECT_THAT(folders, HasSubstr("\nd /run/rubicon/people 3770 root rubicon\n"));
  EXPECT_THAT(folders, HasSubstr("\nd /run/rubicon/people/0 2750 root rubicon\n")) << "before somebody else makes it";
  EXPECT_THAT(read_text(all_.prefix() / "lib/sysusers.d/rubicon.conf"), HasSubstr("\nu rubicon - "));
  if (all_.shell("command -v systemd-tmpfiles && getent passwd rubicon").code != 0) return;
  const auto root = all_.workshop() / "root";
  std::filesystem::create_directories(root / "etc");
  const auto made = all_.shell("cp /etc/passwd /etc/group " + (root / "etc").string() + " && systemd-tmpfiles --root=" +
                               root.string() + " --create " + (all_.prefix() / "lib/tmpfiles.d/rubicon.conf").string());
  EXPECT_EQ(made.code, 0) << made.output;
}

TEST_F(Unit, TakesTheDropInsForItsAddresses) {
  const bool systemd = all_.shell("command -v systemd-analyze").code == 0;
  EXPECT_THAT(words("IPAddressDeny"), testing::ElementsAre("any"));
  EXPECT_THAT(words("IPAddressAllow"), testing::IsSupersetOf({"localhost", "multicast", "192.168.0.0/16"}));
  for (const auto& [name, allowed] : {std::pair("loopback-only.conf", "\nIPAddressAllow=\nIPAddressAllow=localhost\n"),
                                      std::pair("any-address.conf", "\nIPAddressAllow=any\n")}) {
    const auto drop_in = read_text(all_.prefix() / "share/doc/rubicon/examples" / name);
    EXPECT_THAT(drop_in, HasSubstr(allowed)) << name;
    if (!systemd) continue;
    const auto folder = all_.workshop() / (std::string("with-") + name);
    write_text(folder / "rubicon-proxy@.service", read_text(unit_.parent_path() / "rubicon-proxy@.service"));
    write_text(folder / "rubicon-proxy@.service.d" / name, drop_in);
    const auto verified = all_.shell("systemd-analyze verify --man=no " + (folder / "rubicon-proxy@.service").string());
    EXPECT_EQ(verified.code, 0) << name;
    EXPECT_EQ(verified.output, "") << name;
  }
}

TEST_F(Unit, SaysWhenTheIslandIsUpReloadsAndStops) {
  if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  write_text(island_, sample_island(7));
  Process island(started());
  EXPECT_EQ(manager_.next_with("READY=1"), "READY=1\nSTATUS=island 7 (home) is up: 1 network");
  // Whoever waited for that finds the devices.
  const auto lit = all_.shell(RUBICON_BINARY_DIR "/bin/example-2_command lamp on");
  EXPECT_EQ(lit.code, 0) << lit.output;

  island.signal(SIGHUP);
  EXPECT_THAT(manager_.next_with("RELOADING=1"), HasSubstr("MONOTONIC_USEC="));
  EXPECT_EQ(manager_.next_with("READY=1"), "READY=1\nSTATUS=island 7 (home) is up: 1 network");

  write_text(island_, "island: {}\n");
  island.signal(SIGHUP);
  EXPECT_NE(manager_.next_with("RELOADING=1"), "");
  EXPECT_THAT(manager_.next_with("READY=1"), HasSubstr("the last reload was refused: "));

  island.signal(SIGTERM);
  EXPECT_THAT(manager_.next_with("STOPPING=1"), StartsWith("STOPPING=1\nSTATUS="));
  EXPECT_EQ(island.exit_code(), 0);
}

TEST_F(Unit, ALoopThatIsStuckGivesNoSignsOfLife) {
  if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  write_text(island_, sample_island(7));
  Process island(started());
  ASSERT_NE(manager_.next_with("READY=1"), "");
  for (int sign = 0; sign < 5; ++sign) ASSERT_EQ(manager_.next_with("WATCHDOG=1"), "WATCHDOG=1");
  island.signal(SIGSTOP);
  while (manager_.next(0ms)) continue;  // what it said before it stopped
  std::size_t said = 0;
  while (manager_.next(600ms)) ASSERT_LT(++said, 3U);  // it may have been between two
  island.signal(SIGCONT);
  EXPECT_EQ(manager_.next_with("WATCHDOG=1"), "WATCHDOG=1");
}

TEST_F(Unit, AWrongConfigurationEndsWithTheCodeThatIsNotTriedAgain) {
  write_text(island_, "island: {id: 70000}\n");
  Process island(started());
  const auto code = island.exit_code();
  EXPECT_EQ(words("RestartPreventExitStatus"), std::vector<std::string>{std::to_string(code)});
  EXPECT_THAT(island.errors(), HasSubstr("home.yaml:1"));
  EXPECT_FALSE(manager_.next(0ms));
}

}  // namespace
}  // namespace rubicon::install
