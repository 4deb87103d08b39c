#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <set>

#include "apps/rubicon/kernel_program.h"
#include "apps/rubicon/live_island.h"
#include "apps/rubicon/output/output.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;
using tuples::peis::KernelPeer;

/// In a network of its own, so that nothing else is in the PEIS network.
class OnPeis : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  static Outcome on_peis(std::vector<std::string> arguments, const std::string& engine = "peis") {
    arguments.insert(arguments.end(), {"--engine", engine});
    return rubicon(std::move(arguments));
  }
  static std::vector<std::string> column(const Outcome& outcome, const char* member) {
    std::vector<std::string> all;
    for (const auto& line : lines_of(outcome)) {
      if (line.contains(member))
        all.push_back(line[member].is_string() ? line[member].get<std::string>() : line[member].dump());
    }
    return all;
  }
  /// `grade check: what (mend)` of each finding.
  static std::vector<std::string> examine(std::vector<std::string> more = {}, const std::string& length = "100ms") {
    more.insert(more.begin(), {"doctor", "--json", "--for", length});
    std::vector<std::string> all;
    for (const auto& line : lines_of(on_peis(std::move(more))))
      all.push_back(line.value("grade", "") + " " + line.value("check", "") + ": " + line.value("what", "") + " (" +
                    line.value("mend", "") + ")");
    return all;
  }
  /// Again until it finds that, or ten times.
  static std::vector<std::string> examine_until(const std::string& part, const std::vector<std::string>& more = {},
                                                const std::string& length = "100ms") {
    std::vector<std::string> all;
    for (int i = 0;
         i < 10 && std::none_of(all.begin(), all.end(), [&](const auto& one) { return one.find(part) != one.npos; });
         ++i)
      all = examine(more, length);
    return all;
  }
  /// Until it is so, at most half a minute.
  static bool until(const std::function<bool()>& so) {
    const auto end = std::chrono::steady_clock::now() + 30s;
    while (!so() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    return so();
  }

  PrivateNetwork alone_;
  Folder folder_;
};

TEST_F(OnPeis, CommandsNeedNoIslandOfOurs) {
  KernelProgram kernel(101, 9000, {{"robot.arm", "idle"}, {"robot.goal", "none"}, {"kernel.name", "kernel"}});
  const auto all = on_peis({"islands", "--all", "--json"});
  ASSERT_EQ(all.code, 0) << all.errors;
  ASSERT_EQ(lines_of(all).size(), 1U) << all.output;
  const auto line = lines_of(all)[0];
  EXPECT_EQ(line["id"], 101);
  EXPECT_EQ(line["name"], "kernel");
  EXPECT_EQ(line["program"], "peis-kernel 500");
  EXPECT_FALSE(line.contains("devices")) << "its id is one of islands, but it is none";
  const auto islands = on_peis({"islands"});
  EXPECT_EQ(islands.code, kNotThere);
  EXPECT_THAT(islands.errors, HasSubstr("no island (looked in PEIS network default on lo; 0 islands present)"));

  EXPECT_THAT(on_peis({"ls", "robot.*"}).output, AllOf(HasSubstr("101:robot.arm"), HasSubstr("idle")));
  EXPECT_EQ(on_peis({"get", "101:robot.arm"}).output, "idle\n");
  const auto set = on_peis({"set", "101:robot.goal", "kitchen"});
  EXPECT_EQ(set.code, 0) << set.output << set.errors;
  EXPECT_EQ(kernel.value("robot.goal"), "kitchen");
  EXPECT_EQ(on_peis({"get", "101:robot.goal"}).output, "kitchen\n");
  EXPECT_THAT(on_peis({"watch", "101:robot.goal", "--count", "1"}).output, HasSubstr("101:robot.goal = kitchen"));
}

TEST_F(OnPeis, AKernelIsAnOwnerAndAnIslandIsAnIsland) {
  const KernelProgram kernel(42, 9000, {{"robot.arm", "idle"}});
  const auto island = started(folder_.write("a.yaml", small_island(5, "{engine: [dds, peis]}")));
  EXPECT_THAT(column(on_peis({"islands", "--json"}), "id"), UnorderedElementsAre("5"));
  EXPECT_THAT(column(on_peis({"islands", "--json"}, "dds"), "id"), UnorderedElementsAre("5"));
  const auto both = on_peis({"islands", "--all", "--json"}, "dds,peis");
  EXPECT_THAT(column(both, "id"), AllOf(Contains("5").Times(1), Contains("42").Times(1))) << both.output;
  EXPECT_THAT(on_peis({"ls"}).output, HasSubstr("5:proxy.dummy-1.den.sensor.temperature-1.value"));
}

TEST_F(OnPeis, PageAndHistoryOfAnIslandAreComponentsOnBothEngines) {
  const auto file = folder_.write("a.yaml", small_island(5, "{engine: [dds, peis]}") +
                                                "web: {listen: \"127.0.0.1:8642\"}\nhistory: {file: h.db}\n");
  const auto island = started(file);
  std::vector<std::string> names;
  until([&] { return (names = column(on_peis({"islands", "--all", "--json"}), "name")).size() == 4; });
  EXPECT_THAT(names, AllOf(Contains("small"), Contains("console of the island"))) << island->errors();
  EXPECT_EQ(names.size(), 4U) << "island, console, page and history: " << testing::PrintToString(names);
  for (const auto& id : column(on_peis({"islands", "--all", "--json"}), "id")) EXPECT_LT(std::stoul(id), 1UL << 31U);
}

TEST_F(OnPeis, TheConfigurationOfAnIslandNamesThePlace) {
  const KernelProgram kernel(101, 9000, {{"robot.arm", "idle"}}, [](KernelPeer& peer) { peer.network = "lab"; });
  const auto file = folder_.write(
      "a.yaml",
      small_island(5, "{engine: peis, peis: {network: lab, connect: [\"tcp://127.0.0.1:9000\"], multicast: no}}"));
  EXPECT_EQ(rubicon({"get", "101:robot.arm", "--config", file}).output, "idle\n");
  EXPECT_EQ(on_peis({"get", "101:robot.arm", "--peis-network", "lab", "--peis-connect", "tcp://127.0.0.1:9000",
                     "--peis-multicast", "no"})
                .output,
            "idle\n");
}

TEST_F(OnPeis, OptionsThatWouldDoNothingAreErrorsOfUse) {
  EXPECT_EQ(on_peis({"islands", "--domain", "3"}).code, kUsage);
  EXPECT_EQ(on_peis({"islands", "--peis-network", "lab"}, "dds").code, kUsage);
  const auto away = on_peis({"islands", "--peis-connect", "tcp://10.9.9.1:9999"});
  EXPECT_EQ(away.code, kFailed);
  EXPECT_THAT(away.errors, HasSubstr("PEIS: connect to 'tcp://10.9.9.1:9999': lo reaches no other host"));
}

TEST_F(OnPeis, TheDoctorFindsNothingWrongWithKernelsAlone) {
  const KernelProgram kernel(101, 9000, {{"robot.arm", "idle"}});
  const auto found = examine_until("good peis-components: PEIS network default: 1 kernel");
  EXPECT_THAT(found, Contains(HasSubstr("good peis-components: PEIS network default: 1 kernel, 0 components of ours")));
  EXPECT_THAT(found, Contains(HasSubstr("good peis-port: this program listens at 127.0.0.1:80")));
  EXPECT_THAT(found, Not(Contains(HasSubstr("problem"))));
}

TEST_F(OnPeis, TheDoctorNamesAnEmptyNetwork) {
  EXPECT_THAT(examine(),
              Contains(HasSubstr("problem peis-components: no component in PEIS network default on lo (start "
                                 "one with network default")));
}

TEST_F(OnPeis, TheDoctorNamesAForeignNetwork) {
  const KernelProgram kernel(101, 9000, {}, [](KernelPeer& peer) { peer.network = "lab"; });
  const auto found = examine_until("note peis-network");
  EXPECT_THAT(found, Contains(AllOf(HasSubstr("note peis-network: component 101 (kernel@"),
                                    HasSubstr("belongs to PEIS network lab, rubicon looks in network default"),
                                    HasSubstr("--peis-network lab"))));
}

TEST_F(OnPeis, TheDoctorNamesIdsThatNoComponentHas) {
  const KernelProgram kernel(101, 9000,
                             {{"kernel.subscribers", "(\n  ( 4711 101.robot.arm )\n  ( 101 -1.x )\n)\n"},
                              {"robot.next", "(META 815 robot.arm)"},
                              {"robot.self", "(META 101 robot.arm)"}});
  const auto found = examine_until("101:robot.next names id 815");
  EXPECT_THAT(found, Contains(HasSubstr("note unknown-id: 101:kernel.subscribers names id 4711, which no component")));
  EXPECT_THAT(found, Contains(HasSubstr("note unknown-id: 101:robot.next names id 815, which no component has")));
  EXPECT_THAT(found, Not(Contains(HasSubstr("robot.self"))));
}

TEST_F(OnPeis, TheDoctorNamesAnIdThatTwoProgramsUse) {
  const KernelProgram first(101, 9000, {}), second(101, 9001, {}, [](KernelPeer&peer) { peer.magic += 1; });
  EXPECT_THAT(examine_until("problem id-twice", {}, "3s"),
              Contains(HasSubstr("problem id-twice: id 101 is used by two programs")));
}

TEST_F(OnPeis, TheDoctorNamesAComponentToWhichNoConnectionSucceeds) {
  const KernelProgram kernel(101, 9000, {}, [](KernelPeer& peer) {
    peer.stop_listening();
    peer.connects = false;
  });
  EXPECT_THAT(examine_until("problem unreachable: component 101", {"--peis-connect", "tcp://127.0.0.1:9999"}, "3s"),
              AllOf(Contains(AllOf(HasSubstr("problem unreachable: component 101"), HasSubstr("Connection refused"))),
                    Contains(HasSubstr("problem unreachable: 127.0.0.1:9999 cannot be connected to"))));
}

TEST_F(OnPeis, TheDoctorNamesAnotherVersionOfTheProtocol) {
  const KernelProgram kernel(101, 9000, {}, [](KernelPeer& peer) {
    peer.stop_listening();
    peer.version = 600;
  });
  EXPECT_THAT(examine_until("problem version", {}, "4s"),
              Contains(AllOf(HasSubstr("problem version: "), HasSubstr("600"))));
}

TEST_F(OnPeis, TheDoctorNamesPortsThatAreTaken) {
  const int taken = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(65535);
  ASSERT_EQ(::bind(taken, reinterpret_cast<const sockaddr*>(&where), sizeof where), 0);
  ASSERT_EQ(::listen(taken, 1), 0);
  const auto found = examine({"--peis-listen", "65535"});
  ::close(taken);
  EXPECT_THAT(found, Contains(HasSubstr("problem peis-port: no TCP port from 65535 on is free for PEIS")));
}

TEST_F(OnPeis, WhatAnIslandRefusesIsCountedInItsTuplesAndExplained) {
  KernelProgram kernel(101, 9000, {});
  const auto island = started(folder_.write("a.yaml", small_island(5, "{engine: peis}")));
  ASSERT_TRUE(until([&] { return kernel.routable(5); }));
  kernel.set_remote(5, "kernel.do-quit", "yes");
  kernel.set_remote(5, "proxy.islands", "mine");
  const auto counter = [](const std::string& name) {
    return on_peis({"get", "5:proxy.property." + name + ".value"}).output;
  };
  EXPECT_TRUE(until([&] { return counter("peis-ignored-quits") == "1\n"; }));
  EXPECT_TRUE(until([&] { return counter("peis-refused-sets") == "1\n"; }));
  const auto found = examine();
  EXPECT_THAT(found, Contains(HasSubstr("note peis: island 5 small: peis-ignored-quits = 1: a program asked")));
  EXPECT_THAT(found, Contains(HasSubstr("note peis: island 5 small: peis-refused-sets = 1: remote sets of kernels")));
  EXPECT_THAT(found, Not(Contains(HasSubstr("loss: island 5 small: peis-"))));
}

}  // namespace
}  // namespace rubicon::cli
