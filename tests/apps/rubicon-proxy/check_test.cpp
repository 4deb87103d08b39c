#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {
namespace {

using namespace support;
namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

/// `rubicon-proxy check` of one file.
class CheckOfAFile : public testing::Test {
 protected:
  CheckOfAFile() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~CheckOfAFile() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  Outcome check(const std::string& networks) const {
    return run_to_end(
        {kDaemon, "check", "--elsewhere", write("island.yaml", "island: {id: 12, name: school}\n" + networks)});
  }

  fs::path folder_ = fs::path(testing::TempDir()) / ("rubicon_check_" + std::to_string(::getpid()));
};

TEST_F(CheckOfAFile, OneSerialLineBelongsToOneNetwork) {
  fs::create_symlink("/dev/null", folder_ / "by-id");
  const auto twice = check(
      "networks:\n  wsn-1: {type: wsn, source: \"serial@/dev/ttyUSB0:telosb\"}\n"
      "  wsn-2: {type: wsn, source: \"serial@/dev/ttyUSB0:57600+file@all.log\"}\n");
  EXPECT_EQ(twice.code, 2) << twice.output;
  EXPECT_THAT(twice.errors, HasSubstr("island.yaml:4:30: networks.wsn-2.source: /dev/ttyUSB0 is the serial line of "
                                      "network wsn-1 too (" +
                                      (folder_ / "island.yaml").string() + ":3:30), expected a device of its own"));
  const auto linked = check(
      "networks:\n  wsn-1: {type: wsn, source: \"serial@/dev/null:telosb\"}\n  wsn-2: {type: wsn, source: \"serial@" +
      (folder_ / "by-id").string() + ":telosb\"}\n");
  EXPECT_EQ(linked.code, 2) << "a link to the same device";
  const auto two = check(
      "networks:\n  wsn-1: {type: wsn, source: \"serial@/dev/ttyUSB0:telosb\"}\n"
      "  wsn-2: {type: wsn, source: \"serial@/dev/ttyUSB1:telosb\"}\n"
      "  wsn-3: {type: wsn, source: \"sf@localhost:9002\"}\n  wsn-4: {type: wsn, source: \"sf@localhost:9002\"}\n");
  EXPECT_EQ(two.code, 0) << two.errors;
}

TEST_F(CheckOfAFile, OnePortBelongsToOneOption) {
  const auto twice = check(
      "web: {listen: 127.0.0.1:9002}\nnetworks:\n  knx-1: {type: knx, host: a, local-port: 5000}\n"
      "  knx-2: {type: knx, host: b, local-port: 5000}\n"
      "  wsn-1: {type: wsn, source: \"sf@localhost:9001\", share: 9002}\n");
  EXPECT_EQ(twice.code, 2) << twice.output;
  const auto file = (folder_ / "island.yaml").string();
  EXPECT_THAT(twice.errors, HasSubstr("island.yaml:5:43: networks.knx-2.local-port: 5000 is the UDP port of "
                                      "networks.knx-1.local-port too (" +
                                      file + ":4:43), expected a port of its own"));
  EXPECT_THAT(twice.errors,
              HasSubstr("networks.wsn-1.share: 9002 is the TCP port of web.listen too (" + file + ":2:15)"));
  const auto free = check(
      "web: {listen: 127.0.0.1:5000}\nnetworks:\n  knx-1: {type: knx, host: a, local-port: 5000}\n"
      "  knx-2: {type: knx, host: b, local-port: 0}\n  knx-3: {type: knx, host: c, local-port: 0}\n"
      "  knx-4: {type: knx, host: d, via: tunnel-tcp, local-port: 5000}\n"
      "  wsn-1: {type: wsn, source: \"sf@localhost:9001\", share: 9002}\n"
      "  wsn-2: {type: wsn, source: \"sf@localhost:9001\", share: \"192.0.2.1:9002\"}\n");
  EXPECT_EQ(free.code, 0) << free.errors;
}

TEST_F(CheckOfAFile, APasswordThatOthersCanReadIsAWarning) {
  const auto secret = write("broker.password", "secret\n");
  const std::string networks =
      "networks:\n  zigbee: {type: zigbee, broker: {host: localhost, user: u, password-file: broker.password}}\n";
  fs::permissions(secret, fs::perms(0644));
  const auto open = check(networks);
  EXPECT_EQ(open.code, 0) << open.errors;
  EXPECT_THAT(open.errors, HasSubstr("warning: " + (folder_ / "island.yaml").string() +
                                     ":3:61: networks.zigbee.broker.password-file: " + secret +
                                     ": all users of this machine can read this password; run chmod 600"));
  fs::permissions(secret, fs::perms(0600));
  EXPECT_THAT(check(networks).errors, Not(HasSubstr("password")));
}

TEST_F(CheckOfAFile, AMissingWordIsAskedForWithAnExample) {
  for (const auto& [networks, said] : std::vector<std::pair<std::string, std::string>>{
           {"networks: {knx: {type: knx, via: tunnel}}\n",
            "'host' is missing, expected the name or address of the interface, such as 192.168.1.10"},
           {"networks: {knx: {host: 192.168.10.5}}\n", "'type' is missing, expected one of: dummy, "},
           {"networks: {dumy: {type: dumy}}\n", "is 'dumy'; did you mean 'dummy'? expected one of: dummy, "},
           {"networks: {dummy: {type: dummy, simulate: {a: {sensors: {temprature-1: {}}}}}}\n",
            "unknown type 'temprature'; did you mean 'temperature'? expected one that `rubicon types` lists"},
           {"networks: {knx: {type: knx, via: tunel, host: a}}\n", "did you mean 'tunnel'"},
           {"web: {tokens: {}}\n", "'file' is missing, expected a file that `rubicon token` writes, such as"}}) {
    const auto checked = check(networks);
    EXPECT_EQ(checked.code, 2) << networks;
    EXPECT_THAT(checked.errors, HasSubstr(said));
  }
}

TEST_F(CheckOfAFile, TheStartSaysWhoMayCommandAnIslandWithoutRights) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  const auto file = write("home.yaml", "island: {id: 12, name: school}\nnetworks: {dummy-1: {type: dummy}}\n");
  for (const auto& [engine, said] : std::vector<std::pair<std::string, std::string>>{
           {"tuples.engine=dds", "is up: 1 network; anybody on this host may command it"},
           {"tuples.host=yes", "is up: 1 network; whoever may enter " + alone.folder() + " may command it"},
           {"tuples.engine=memory", "is up: 1 network\n"}}) {
    Process island({kDaemon, "run", file, "--set", "tuples.trust=no", "--set", engine, "--shell"});
    island.write("quit\n");
    EXPECT_EQ(island.exit_code(), 0) << island.errors();
    EXPECT_THAT(island.errors(), HasSubstr(said));
  }
  EXPECT_THAT(run_to_end({kDaemon, "check", file}).output,
              HasSubstr("whoever may enter " + alone.folder() + " may command it"));
}

}  // namespace
}  // namespace rubicon::daemon
