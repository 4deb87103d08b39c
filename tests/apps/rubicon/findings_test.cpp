#include "apps/rubicon/doctor/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::cli {
namespace {

using testing::HasSubstr;
using Grade = Finding::Grade;

const std::vector<transport::Interface> kThere{{"lo", "127.0.0.1", true, false},
                                               {"eth0", "10.0.0.1", true, true},
                                               {"tun0", "10.8.0.1", true, false},
                                               {"eth1", "10.0.1.1", false, true},
                                               {"eth2", "", true, true}};

Finding of_interface(const std::string& name, std::vector<std::string> peers = {}) {
  client::Options options;
  options.interfaces = {name};
  options.peers = std::move(peers);
  return check_interfaces(options, kThere).at(0);
}

TEST(Findings, AnInterfaceWithoutMulticastNeedsPeers) {
  EXPECT_EQ(of_interface("tun0").check, "no-multicast");
  EXPECT_EQ(of_interface("tun0").grade, Grade::kProblem);
  EXPECT_EQ(of_interface("tun0", {"10.8.0.2"}).grade, Grade::kGood);
  EXPECT_EQ(of_interface("eth0").grade, Grade::kGood);
  EXPECT_EQ(of_interface("lo").grade, Grade::kGood);
}

TEST(Findings, AnInterfaceThatCannotWorkIsNamed) {
  EXPECT_THAT(of_interface("wlan0").fix, HasSubstr("lo, eth0"));
  EXPECT_THAT(of_interface("eth1").what, HasSubstr("down"));
  EXPECT_THAT(of_interface("eth2").what, HasSubstr("no IPv4 address"));
}

TEST(Findings, AFullHostHasNoPlace) {
  EXPECT_EQ(check_places(0, tuples::dds::kMaxProcessesPerHost - 1).grade, Grade::kGood);
  EXPECT_EQ(check_places(0, tuples::dds::kMaxProcessesPerHost).grade, Grade::kProblem);
}

TEST(Findings, PeersAreToldApartByTheirSilence) {
  EXPECT_THAT(check_peer("p", 0, {"Network is unreachable", 0, 0, false}).what, HasSubstr("Network is unreachable"));
  EXPECT_EQ(check_peer("p", 0, {"", 0, 8, false}).check, "firewall");
  EXPECT_EQ(check_peer("p", 0, {"", 0, 8, false}).grade, Grade::kProblem);
  EXPECT_EQ(check_peer("p", 0, {"", 8, 0, true}).grade, Grade::kNote);
  EXPECT_EQ(check_peer("p", 0, {"", 7, 1, true}).grade, Grade::kGood);
  EXPECT_THAT(check_peer("p", 2, {"", 0, 8, false}).fix, HasSubstr("7900 to 8149"));
}

client::ComponentStart start(std::uint32_t id, std::uint64_t incarnation, bool present, unsigned version = 1) {
  return {OwnerId(id), incarnation, version, present, {"", "host" + std::to_string(incarnation), "", "", {}, {}}};
}

TEST(Findings, AnotherVersionIsAProblemAsLongAsItIsThere) {
  EXPECT_EQ(check_versions({start(1, 5, true), start(2, 6, false, 9)}, 1).at(0).grade, Grade::kGood);
  const auto found = check_versions({start(1, 5, true), start(2, 6, true, 9)}, 1);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].grade, Grade::kProblem);
  EXPECT_THAT(found[0].what, HasSubstr("component 2 on host6 uses protocol version 9"));
}

TEST(Findings, AnIdThatIsTakenTwiceIsNamedWithItsPlaces) {
  EXPECT_EQ(check_twins({start(1, 5, true), start(2, 6, true)}).at(0).grade, Grade::kGood);
  const auto both = check_twins({start(1, 5, true), start(1, 6, true)});
  ASSERT_EQ(both.size(), 1U);
  EXPECT_EQ(both[0].check, "island-twice");
  EXPECT_THAT(both[0].what, HasSubstr("host5 and host6"));
  EXPECT_THAT(check_twins({start(1, 5, true), start(1, 6, false)}).at(0).what, HasSubstr("started 2 times"));
}

TEST(Findings, AComponentWhoseHostHadNoTimeIsAProblemWithTheClockAsItsRemedy) {
  constexpr std::uint64_t kNoTime = 77'147'364'090, kTime = 1'795'000'000'000'000;
  const WallTime now{std::chrono::microseconds(kTime)};
  const auto found = check_clocks({start(6541, kNoTime, true), start(7, kNoTime, false), start(8, kTime, true)}, now);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].check, "clock");
  EXPECT_EQ(found[0].grade, Finding::Grade::kProblem);
  EXPECT_THAT(found[0].what,
              HasSubstr("component 6541 says that it started on 1970-01-01 21:25 UTC, before the clock"));
  EXPECT_THAT(found[0].fix, HasSubstr("timedatectl"));
  const auto own = check_clocks({}, WallTime(std::chrono::hours(1)));
  ASSERT_EQ(own.size(), 1U);
  EXPECT_THAT(own[0].what, HasSubstr("the clock of this host says 1970"));
  EXPECT_EQ(check_complaint("a peer is odd").grade, Finding::Grade::kNote);
}

TEST(HostNetwork, ReadsThePortsOfTheKernelsTable) {
  const auto ports = ports_in(
      "   sl  local_address rem_address   st tx_queue rx_queue\n"
      "  123: 00000000:1CF2 00000000:0000 07 00000000:00000000\n"
      "  124: 0100007F:1CF3 00000000:0000 07 00000000:00000000\n"
      "rubbish\n\n 9: zz 1\n");
  EXPECT_EQ(ports, (std::set<unsigned>{7410, 7411}));
}

TEST(HostNetwork, CountsProcessesByTheirPairsOfPorts) {
  const auto found = processes_by_domain({7400, 7410, 7411, 7412, 7660, 7661, 7662, 7663, 40000});
  EXPECT_EQ(found, (std::map<unsigned, unsigned>{{0, 1}, {1, 2}}));
}

}  // namespace
}  // namespace rubicon::cli
