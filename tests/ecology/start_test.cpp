#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "ecology/lan.h"
#include "support/process.h"

namespace rubicon::ecology {
namespace {

using testing::HasSubstr;

const std::string kProxy = RUBICON_BINARY_DIR "/bin/rubicon-proxy";

/// The daemon on a virtual host with an obstacle: it ends at once with instructions what to do.
class AStart : public testing::Test {
 protected:
  void SetUp() override {
    if (!lan_.made()) GTEST_SKIP() << lan_.reason();
    file_ =
        (std::filesystem::path(testing::TempDir()) / ("rubicon_start" + std::to_string(::getpid()) + ".yaml")).string();
  }
  void TearDown() override { std::filesystem::remove(file_); }

  support::Outcome run(const std::string& more, const std::vector<std::string>& arguments = {}) const {
    std::ofstream(file_, std::ios::binary) << "island: {id: 1, name: island}\n" << more;
    std::vector<std::string> words{kProxy, "run", file_, "--shell"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const Host::Visit there(lan_.host(0));
    return support::run_to_end(words, "quit\n");
  }

  Lan lan_{1};
  std::string file_;
};

TEST_F(AStart, WithNothingInItsWayIsGood) {
  const auto outcome = run("");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
}

TEST_F(AStart, WithoutLoopbackSaysHowToMendIt) {
  lan_.loopback_down(0);
  EXPECT_EQ(run("").code, 0) << "programs of one host need no network";
  const auto outcome = run("", {"--set", "tuples.engine=dds"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(
      outcome.errors,
      HasSubstr("DDS: interface 'lo' is down: bring it up (ip link set lo up), or set tuples.engine: memory\n"));
  EXPECT_EQ(run("", {"--set", "tuples.engine=memory"}).code, 0);
}

TEST_F(AStart, OnAnAbsentInterfaceNamesThoseThereAre) {
  const auto outcome = run("tuples: {interfaces: [cable, eth7]}\n");
  EXPECT_EQ(outcome.code, 1) << "it may come, whoever starts this again may succeed";
  EXPECT_THAT(outcome.errors, HasSubstr(file_ + ":2:22: tuples.interfaces: DDS: there is no interface 'eth7' on this "
                                                "host; there are: lo, cable\n"));
}

TEST_F(AStart, OnAnInterfaceThatIsDownSaysSo) {
  lan_.interface_down(0);
  EXPECT_THAT(run("tuples: {interfaces: cable}\n").errors,
              HasSubstr("interface 'cable' is down: bring it up (ip link set cable up)\n"));
}

TEST_F(AStart, WithoutAFreeParticipantIndexSaysHowManyAreThereAndWhatToDo) {
  const Host::Visit there(lan_.host(0));
  std::vector<int> sockets;
  for (int i = 0; i < 120; ++i) {
    sockets.push_back(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(7410 + 2 * i));
    ASSERT_EQ(::bind(sockets.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  EXPECT_EQ(run("").code, 0) << "on this host there is room";
  const auto full = run("tuples: {engine: dds}\n");
  EXPECT_EQ(full.code, 1);
  EXPECT_THAT(full.errors, HasSubstr("DDS: domain 0 has no room for one more process on this host: 120 run already "
                                     "(UDP ports 7410 to 7649 are taken). End some of them, or use another "
                                     "tuples.domain\n"));
  EXPECT_EQ(run("tuples: {engine: dds, domain: 1}\n").code, 0) << "another domain has room";
  ::close(sockets.back());
  EXPECT_EQ(run("tuples: {engine: dds}\n").code, 0) << "the last one is used as well";
  sockets.pop_back();
  for (const int socket : sockets) ::close(socket);
}

TEST_F(AStart, WithoutReadersIsNoStartAndSaysWhichOneIsMissing) {
  std::ofstream(file_, std::ios::binary) << "island: {id: 1, name: island}\ntuples: {engine: dds}\n";
  const Host::Visit there(lan_.host(0));
  // The library of a sanitizer must be loaded first.
  const auto outcome = support::run_to_end({"env", "LD_PRELOAD=" RUBICON_NO_READERS,
                                            "ASAN_OPTIONS=verify_asan_link_order=0", kProxy, "run", file_, "--shell"},
                                           "quit\n");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("DDS: reader of frames cannot be made: Out Of Resources"));
  EXPECT_THAT(outcome.errors, testing::Not(HasSubstr("is up")));
}

TEST_F(AStart, GoesOnWithoutAPeerThatNobodyKnows) {
  const auto outcome = run("tuples: {interfaces: cable, peers: [nobody.invalid]}\n");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, HasSubstr("tuples.peers: 'nobody.invalid' cannot be resolved"));
}

}  // namespace
}  // namespace rubicon::ecology
