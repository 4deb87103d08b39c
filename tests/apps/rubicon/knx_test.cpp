#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <thread>

#include "apps/rubicon/live_island.h"
#include "support/conversation.h"
#include "support/knx_project.h"
#include "support/knxd.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

TEST(KnxConvert, DecodesAndEncodesOneValue) {
  EXPECT_EQ(rubicon({"knx", "decode", "9.001", "0c33"}).output, "21.5\n");
  EXPECT_EQ(rubicon({"knx", "decode", "9.001", "0c", "33"}).output, "21.5\n");
  EXPECT_EQ(rubicon({"knx", "encode", "9.001", "-5.3"}).output, "85ee\n");
  EXPECT_EQ(rubicon({"knx", "encode", "10.001", "Fri", "13:30:15"}).output, "ad1e0f\n");
  EXPECT_EQ(rubicon({"knx", "encode", "DPST-1-8", "down"}).output, "01\n");
}

TEST(KnxConvert, SaysWhatIsWrongWithAValue) {
  const auto cold = rubicon({"knx", "encode", "9.001", "-300"});
  EXPECT_EQ(cold.code, 2);
  EXPECT_EQ(cold.output, "");
  EXPECT_THAT(cold.errors, HasSubstr("-300"));
  EXPECT_EQ(rubicon({"knx", "decode", "9.001", "0c3"}).code, 2);
  EXPECT_EQ(rubicon({"knx", "decode", "999.999", "00"}).code, 2);
}

TEST(KnxConvert, AnswersALineForEachLine) {
  const auto decoded = rubicon({"knx", "decode"}, "1.001 01\n9.001 0c33\n9.001 0c\n20.102 01\n\n");
  EXPECT_EQ(decoded.code, 1) << "some were wrong";
  std::istringstream lines(decoded.output);
  std::vector<std::string> all;
  for (std::string line; std::getline(lines, line);) all.push_back(line);
  ASSERT_EQ(all.size(), 5U) << decoded.output;
  EXPECT_EQ(all[0], "on");
  EXPECT_EQ(all[1], "21.5");
  EXPECT_THAT(all[2], StartsWith("error: "));
  EXPECT_EQ(all[3], "comfort");
  EXPECT_THAT(all[4], StartsWith("error: "));
  EXPECT_EQ(rubicon({"knx", "encode"}, "5.001 50\n1.001 on").output, "80\n01\n");
}

/// Asks line by line, as programs do that keep it running.
TEST(KnxConvert, AnswersBeforeTheNextLineComes) {
  Process encoder({kProgram, "knx", "encode"});
  encoder.write("9.001 21.5\n");
  EXPECT_EQ(encoder.line(), "0c33");
  encoder.write("1.001 on\n");
  EXPECT_EQ(encoder.line(), "01");
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

constexpr std::string_view kExport =
    "\"Group name\";\"Address\";\"Central\";\"Unfiltered\";\"Description\";\"DatapointType\";\"Security\"\r\n"
    "\"Hall light switch\";\"1/0/1\";\"\";\"\";\"\";\"DPST-1-1\";\"Auto\"\r\n"
    "\"Hall light status\";\"1/0/2\";\"\";\"\";\"\";\"DPST-1-1\";\"Auto\"\r\n"
    "\"Hall temperature\";\"1/2/7\";\"\";\"\";\"\";\"DPST-9-1\";\"Auto\"\r\n"
    "\"No good\";\"99/0/1\";\"\";\"\";\"\";\"DPST-1-1\";\"Auto\"\r\n";

TEST(KnxImport, PrintsTheRecordAndReportsWhatItGuessed) {
  const Folder folder;
  const auto file = folder.write("flat.csv", std::string(kExport));
  const auto imported = rubicon({"knx", "import", file});
  EXPECT_EQ(imported.code, 9) << imported.errors;
  EXPECT_THAT(imported.output, HasSubstr("1/0/1"));
  EXPECT_THAT(imported.output, HasSubstr("state: 1/0/2"));
  EXPECT_THAT(imported.errors, HasSubstr("99/0/1"));
  EXPECT_THAT(imported.errors, HasSubstr("1/0/2"));
  const auto honest = rubicon({"knx", "import", "--no-guess", file});
  EXPECT_EQ(honest.output.find("state: 1/0/2"), std::string::npos);
  const auto record = folder.write("flat.yaml", imported.output);
  const auto again = rubicon({"knx", "import", file, "--merge", record});
  EXPECT_EQ(again.output, imported.output) << "the second time nothing is new";
  EXPECT_EQ(rubicon({"knx", "import", folder.file("none.csv")}).code, 1);
  EXPECT_EQ(rubicon({"knx", "import", file, "--merge", file}).code, 2) << "no record";
}

/// Scripts see by the exit code whether something is missing.
TEST(KnxImport, TheExitCodeSaysWhetherAllLinesAreThere) {
  const Folder folder;
  const std::string broken(kExport), whole = broken.substr(0, broken.find("\"No good\""));
  const auto record = folder.file("flat.yaml");
  const auto code_of = [&](const std::string& text, const std::string& output) {
    return rubicon({"knx", "import", folder.write("flat.csv", text), "--output", output}).code;
  };
  EXPECT_EQ(code_of(whole, record), 0);
  const auto points = content_of(record);
  EXPECT_EQ(code_of(broken, record), 9);
  EXPECT_EQ(content_of(record), points) << "the lines that are good";
  EXPECT_EQ(code_of(whole + "\"Odd\";\"1/2/8\";\"\";\"\";\"\";\"DPST-5-250\";\"Auto\"\r\n", record), 0) << "a warning";
  EXPECT_EQ(code_of(broken, folder.file("none/flat.yaml")), 1) << "nothing is written";
}

TEST(KnxImport, KeepsWhichGroupsAreSecured) {
  const Folder folder;
  std::string text(kExport);
  const auto first = rubicon({"knx", "import", folder.write("open.csv", text)});
  EXPECT_THAT(first.output, Not(HasSubstr("secured-groups")));
  text.replace(text.find("DPST-9-1\";\"Auto"), 15, "DPST-9-1\";\"On");
  const auto file = folder.write("flat.csv", text);
  const auto record = folder.write("flat.yaml", rubicon({"knx", "import", file}).output);
  EXPECT_THAT(content_of(record), HasSubstr("secured-groups: [1/2/7]"));
  const auto again = rubicon({"knx", "import", folder.file("open.csv"), "--merge", record});
  EXPECT_THAT(again.output, HasSubstr("secured-groups: [1/2/7]")) << "a list without it does not know";
}

TEST(KnxImport, WithoutAnyAddressNothingIsReplaced) {
  const Folder folder;
  const auto record = folder.write("flat.yaml", "groups: {}\n");
  support::KnxHouse empty;
  for (const auto& file :
       {folder.write("empty.knxproj", empty.file()), folder.write("wrong.csv", "\"Lamp\";\"99/0/1\"\r\n")}) {
    const auto imported = rubicon({"knx", "import", file, "--output", record});
    EXPECT_EQ(imported.code, 1) << file;
    EXPECT_THAT(imported.errors, HasSubstr("nothing is written")) << file;
    EXPECT_EQ(content_of(record), "groups: {}\n");
    EXPECT_EQ(rubicon({"knx", "import", file}).output, "");
  }
}

TEST(KnxImport, ReplacesTheVeryRecordThatItMerges) {
  const Folder folder;
  const auto file = folder.write("flat.csv", std::string(kExport));
  const auto record = folder.file("flat.yaml");
  const auto first = rubicon({"knx", "import", file, "--output", record});
  EXPECT_EQ(first.code, 9) << first.errors;
  EXPECT_EQ(first.output, "");
  EXPECT_THAT(first.errors, HasSubstr("99/0/1")) << "the report";
  const auto text = rubicon({"knx", "import", file}).output;
  EXPECT_EQ(content_of(record), text);
  EXPECT_EQ(rubicon({"knx", "import", file, "--merge", record, "--output", record}).code, 9);
  EXPECT_EQ(content_of(record), text) << "nothing is lost, nothing is new";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.file("")), {}), 2) << "no file is left over";
}

TEST(KnxImport, SaysThatARecordIsEmptyAndThatAFileCannotBeWritten) {
  const Folder folder;
  const auto file = folder.write("flat.csv", std::string(kExport));
  const auto empty = rubicon({"knx", "import", file, "--merge", folder.write("flat.yaml", "\n")});
  EXPECT_EQ(empty.code, 2);
  EXPECT_THAT(empty.errors, HasSubstr("flat.yaml is empty"));
  EXPECT_THAT(empty.errors, HasSubstr("--output"));
  const auto nowhere = rubicon({"knx", "import", file, "--output", folder.file("none/flat.yaml")});
  EXPECT_EQ(nowhere.code, 1);
  EXPECT_THAT(nowhere.errors, HasSubstr("cannot be written"));
  EXPECT_EQ(rubicon({"knx", "import", file, "--output", folder.file("")}).code, 1) << "a folder";
}

TEST(KnxImport, AnIslandTakesTheExportAndTheRecord) {
  const Folder folder;
  const auto file = folder.write("flat.csv", std::string(kExport));
  folder.write("flat.yaml", rubicon({"knx", "import", file}).output);
  for (const auto* name : {"flat.csv", "flat.yaml"}) {
    const auto island = folder.write("island.yaml",
                                     "island: {id: 6541, name: home}\nnetworks: {knx: {type: knx, host: "
                                     "127.0.0.1, import: " +
                                         std::string(name) + "}}\n");
    const auto checked = support::run_to_end({kDaemon, "check", island});
    EXPECT_EQ(checked.code, 0) << checked.errors << checked.output;
  }
  folder.write("bad.yaml", "groups:\n  1/0/1: {dpt: 1.001, flavour: sweet}\n");
  const auto island =
      folder.write("island.yaml",
                   "island: {id: 6541, name: home}\nnetworks: {knx: {type: knx, host: 127.0.0.1, import: bad.yaml}}\n");
  const auto checked = support::run_to_end({kDaemon, "check", island});
  EXPECT_NE(checked.code, 0);
  EXPECT_THAT(checked.errors + checked.output, HasSubstr("bad.yaml:2:")) << "names the place in the record";
}

TEST(KnxImport, ReadsAProjectWithThePasswordOfAFileOrTheEnvironment) {
  const Folder folder;
  auto house = support::small_house(23);
  const auto open = folder.write("open.knxproj", house.file());
  house.password = "flatpass";
  const auto file = folder.write("house.knxproj", house.file());
  const auto plain = rubicon({"knx", "import", open});
  EXPECT_EQ(plain.code, 0) << plain.errors;
  EXPECT_THAT(plain.output, HasSubstr("1/0/1: {dpt: 1.001, kind: actuator, state: 1/0/2"));
  EXPECT_THAT(plain.errors, HasSubstr("open.knxproj, project of ETS 6 (schema 23): 9 group addresses"));
  const auto missing = rubicon({"knx", "import", file});
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(missing.errors, HasSubstr("none was given: give it with --password-file FILE, or in the environment"));
  const auto right = folder.write("right", "flatpass\n"), wrong = folder.write("wrong", "other\n");
  std::filesystem::permissions(right, std::filesystem::perms::owner_all | std::filesystem::perms::others_read);
  EXPECT_THAT(rubicon({"knx", "import", file, "--password-file", right}).errors, HasSubstr("run chmod 600"));
  for (const auto& path : {right, wrong}) std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  const auto given = rubicon({"knx", "import", file, "--password-file", right});
  EXPECT_EQ(given.code, 0) << given.errors;
  EXPECT_EQ(given.output.find("flatpass"), std::string::npos);
  EXPECT_THAT(rubicon({"knx", "import", file, "--password-file", wrong}).errors,
              HasSubstr("the password of the project P-00F1 is wrong (the password is from " + wrong + ")"));
  const auto list = folder.write("flat.csv", std::string(kExport));
  const auto pointless = rubicon({"knx", "import", list, "--password-file", right});
  EXPECT_EQ(pointless.code, 1);
  EXPECT_THAT(pointless.errors, HasSubstr("--password-file is only for projects of ETS"));
  ::setenv("RUBICON_KNX_PASSWORD", "flatpass", 1);
  EXPECT_EQ(rubicon({"knx", "import", file}).code, 0);
  ::unsetenv("RUBICON_KNX_PASSWORD");
}

TEST(KnxTool, KnowsItsSubcommands) {
  EXPECT_THAT(rubicon({"knx", "--help"}).output, HasSubstr("monitor"));
  EXPECT_EQ(rubicon({"knx"}).code, 2);
  EXPECT_THAT(rubicon({"complete", "--", "knx", "mon"}).output, HasSubstr("monitor"));
  EXPECT_THAT(rubicon({"complete", "--", "knx", "read", "--dir"}).output, HasSubstr("--direct"));
  for (const auto* command : {"monitor", "read"}) {
    const auto typo = rubicon({"knx", command, "1/2/x"});
    EXPECT_EQ(typo.code, 2) << command;
    EXPECT_THAT(typo.errors, HasSubstr("1/2/x"));
  }
  EXPECT_EQ(rubicon({"knx", "monitor", "1/2/7", "99/0/1"}).code, 2);
  EXPECT_THAT(rubicon({"manual"}).output, HasSubstr(".SS knx monitor"));
}

/// An island on a knxd with a lamp that reports, and knxtool as the rest of the bus.
class KnxIsland : public testing::Test {
 protected:
  static constexpr std::string_view kConfiguration =
      "island: {id: 6541, name: home}\n"
      "networks:\n"
      "  knx-hall:\n"
      "    type: knx\n"
      "    host: 127.0.0.1\n"
      "    groups:\n"
      "      1/0/1: {dpt: 1.001, kind: actuator, state: 1/0/2, name: Hall lamp}\n"
      "      1/0/3: {dpt: 5.001, kind: actuator, name: Dimmer that does not report}\n"
      "      1/2/7: {dpt: 9.001, name: Hall temperature}\n"
      "    expose:\n"
      "      6/0/1: {tuple: proxy.dummy-1.den.sensor.temperature-1.value, dpt: 9.001}\n"
      "  dummy-1: {type: dummy, simulate: {den: {sensors: {temperature-1: {wave: steps, values: [21.5], period: "
      "15s}}}}}\n";

  void SetUp() override {
    network_ = std::make_unique<support::KnxNetwork>();
    if (!network_->entered()) GTEST_SKIP() << network_->reason();
    knxd_ = std::make_unique<support::Knxd>(true);
    for (int i = 0; i < 2400 && !knxd_->ready(); ++i) std::this_thread::sleep_for(25ms);
    listener_ = std::make_unique<support::KnxdListener>(*knxd_);
    island_ = started(folder_.write("island.yaml", std::string(kConfiguration)));
    ASSERT_TRUE(until("proxy.knx-hall.status", "\"up\"", 60s));
  }
  /// Until the tuple has this in it.
  testing::AssertionResult until(const std::string& tuple, const std::string& part, std::chrono::seconds patience) {
    return support::until(*island_, "get " + tuple, patience, [&](const json& answer) {
      return answer.value("value", std::string()).find(part) != std::string::npos;
    });
  }
  testing::AssertionResult bus_hears(const std::string& part) const {
    for (int i = 0; i < 2400; ++i) {
      if (listener_->heard().find(part) != std::string::npos) return testing::AssertionSuccess();
      std::this_thread::sleep_for(25ms);
    }
    return testing::AssertionFailure() << listener_->heard();
  }

  /// Somebody on the bus who writes five times a second, also while knxd is away.
  std::unique_ptr<Process> writer(const std::string& command, const std::string& arguments) const {
    const auto once = "knxtool " + command + " " + knxd_->url() + " " + arguments;
    return std::make_unique<Process>(
        std::vector<std::string>{"sh", "-c", "while sleep 0.2; do " + once + " >/dev/null 2>&1; done"});
  }

  std::unique_ptr<support::KnxNetwork> network_;
  std::unique_ptr<support::Knxd> knxd_;
  std::unique_ptr<support::KnxdListener> listener_;
  Folder folder_;
  std::unique_ptr<Process> island_;
};

TEST_F(KnxIsland, ReadsCommandsAndShows) {
  knxd_->tool("groupwrite", {"1/2/7", "0c", "65"});
  EXPECT_TRUE(until("proxy.knx-hall.1_2_7.sensor.temperature-1.value", "22.5", 60s));
  EXPECT_TRUE(bus_hears("to 6/0/1: 0C 33")) << "the exposed tuple";
  island_->write("set proxy.knx-hall.1_0_1.actuator.switch-1.command on\n");
  EXPECT_TRUE(bus_hears("to 1/0/1: 01"));
  knxd_->tool("groupswrite", {"1/0/2", "1"});
  EXPECT_TRUE(until("proxy.knx-hall.1_0_1.actuator.switch-1.status", "confirmed", 60s));
  EXPECT_TRUE(until("proxy.knx-hall.1_0_1.actuator.switch-1.value", "on", 60s));
  knxd_->tool("groupswrite", {"7/7/7", "1"});
  EXPECT_TRUE(until("proxy.knx-hall.property.unassigned.value", "7/7/7", 60s));
}

/// The same by routing: without tunnels and confirmations.
TEST_F(KnxIsland, ByRoutingReadsCommandsAndShows) {
  island_.reset();
  auto text = std::string(kConfiguration);
  const std::string host = "    host: 127.0.0.1\n";
  text.replace(text.find(host), host.size(),
               std::string("    via: routing\n    interface: ") + support::KnxNetwork::kAddress + "\n");
  island_ = started(folder_.write("routing.yaml", text));
  ASSERT_TRUE(until("proxy.knx-hall.status", "\"up\"", 60s));
  EXPECT_TRUE(bus_hears("to 6/0/1: 0C 33")) << "the exposed tuple";
  knxd_->tool("groupwrite", {"1/2/7", "0c", "65"});
  EXPECT_TRUE(until("proxy.knx-hall.1_2_7.sensor.temperature-1.value", "22.5", 60s));
  island_->write("set proxy.knx-hall.1_0_1.actuator.switch-1.command on\n");
  EXPECT_TRUE(bus_hears("to 1/0/1: 01"));
  knxd_->tool("groupswrite", {"1/0/2", "1"});
  EXPECT_TRUE(until("proxy.knx-hall.1_0_1.actuator.switch-1.status", "confirmed", 60s));
  EXPECT_TRUE(until("proxy.knx-hall.1_0_1.actuator.switch-1.value", "on", 60s));
}

TEST_F(KnxIsland, ToolsUseItsLine) {
  const auto written = rubicon({"knx", "write", "5/5/5", "9.001", "-5.3"});
  EXPECT_EQ(written.code, 0) << written.errors;
  EXPECT_TRUE(bus_hears("to 5/5/5: 85 EE"));
  auto device = writer("groupwrite", "1/2/7 0c 33");
  Process monitor({kProgram, "knx", "monitor", "--json", "1/519"});
  const auto seen = monitor.line();
  ASSERT_TRUE(seen);
  EXPECT_EQ(json::parse(*seen)["address"], "1/2/7");
  EXPECT_EQ(json::parse(*seen)["value"], 21.5);
  EXPECT_EQ(json::parse(*seen)["secured"], false);
  const auto none = rubicon({"knx", "read", "3/3/3"});
  EXPECT_EQ(none.code, 4);
  EXPECT_THAT(none.errors, HasSubstr("3/3/3"));
  const auto capture = rubicon({"knx", "capture", folder_.file("bus.pcap")});
  EXPECT_EQ(capture.code, 0) << capture.errors;
  EXPECT_GT(std::filesystem::file_size(folder_.file("bus.pcap")), 24U + 60U);
  EXPECT_EQ(rubicon({"knx", "read", "1/2/7", "--network", "knx-nowhere"}).code, 8);

  device.reset();  // a telegram that arrives while the monitor ends would count as lost
  monitor.signal(SIGINT);
  EXPECT_EQ(monitor.exit_code(), 0) << monitor.errors();
  knxd_->tool("groupswrite", {"7/7/7", "1"});
  EXPECT_TRUE(until("proxy.knx-hall.property.unassigned.value", "7/7/7", 60s));
  EXPECT_EQ(rubicon({"get", "proxy.property.gateway-undeliverable.value"}).output, "0\n")
      << "the network sends no telegrams to a monitor that ended";
}

TEST_F(KnxIsland, ToolsCanHaveATunnelOfTheirOwn) {
  const auto written = rubicon({"knx", "write", "5/5/6", "1.001", "on", "--direct", "127.0.0.1"});
  EXPECT_EQ(written.code, 0) << written.errors;
  EXPECT_TRUE(bus_hears("to 5/5/6: 01"));
  const auto found = rubicon({"knx", "discover", "--host", "127.0.0.1", "--json"});
  EXPECT_EQ(found.code, 0) << found.errors;
  EXPECT_EQ(lines_of(found).at(0)["name"], "test-knxd");
  const auto unreachable = rubicon({"knx", "read", "1/1/1", "--direct", "127.0.0.1:3999"});
  EXPECT_EQ(unreachable.code, 1);
  EXPECT_THAT(unreachable.errors, HasSubstr("no tunnel to 127.0.0.1:3999"));
}

/// What an integrator does first: pulls the plug. Every round the island must be up after knxd is back, ask for each
/// value that is wanted, and take the answers.
class KnxRestarts : public KnxIsland {
 protected:
  using Clock = std::chrono::steady_clock;

  void SetUp() override {
    ASSERT_NO_FATAL_FAILURE(KnxIsland::SetUp());
    if (IsSkipped()) return;
    ASSERT_TRUE(support::ask(*island_, "subscribe proxy.knx-hall.**").value("ok", false));
    monitor_ = std::make_unique<Process>(std::vector<std::string>{
        "sh", "-c", "exec '" + kProgram + "' knx monitor --json >" + folder_.file("telegrams") + " 2>&1"});
    answer(0);
    const auto device = writer("groupwrite", "1/2/7 0c 33");
    for (int i = 0; i < 2400 && content_of(folder_.file("telegrams")).empty(); ++i) std::this_thread::sleep_for(25ms);
  }
  /// The devices of the bus say what they are, different in each round; with a response as to a read.
  void answer(int round) const {
    knxd_->tool("groupsresponse", {"1/0/2", std::to_string(round % 2)});
    knxd_->tool("groupwrite", {"1/2/7", "0c", fmt::format("{:02x}", round)});
  }
  static std::string temperature(int round) { return json((0x400 + round) * 2 / 100.0).dump(); }
  /// Reads of ours on the bus so far.
  std::map<std::string, int> reads() const {
    std::map<std::string, int> count;
    std::istringstream text(content_of(folder_.file("telegrams")));
    for (std::string line; std::getline(text, line);) {
      const auto telegram = json::parse(line, nullptr, false);
      if (telegram.is_object() && telegram.value("own", false) && telegram.value("service", "") == "read")
        ++count[telegram.value("address", "")];
    }
    return count;
  }
  /// Passes over what the subscription and earlier commands say.
  std::string value_of(const std::string& tuple) {
    island_->write("get " + tuple + "\n");
    while (const auto line = island_->line_with("\"" + tuple + "\"")) {
      const auto answer = json::parse(*line, nullptr, false);
      if (answer.contains("ok")) return answer.contains("tuple") ? answer["tuple"].value("value", "") : std::string();
    }
    return {};
  }
  testing::AssertionResult becomes(const std::string& tuple, const std::string& value) {
    std::string seen;
    for (const auto end = Clock::now() + 60s; Clock::now() < end; std::this_thread::sleep_for(10ms)) {
      if ((seen = value_of(tuple)) == value) return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << tuple << " is " << seen << ", expected " << value;
  }
  /// As a device would, the bus answers when it was asked.
  bool asks_again(const std::map<std::string, int>& before) const {
    const auto more = [&](const std::string& address) {
      auto now = reads();
      return now[address] > (before.contains(address) ? before.at(address) : 0);
    };
    for (const auto end = Clock::now() + 60s; Clock::now() < end; std::this_thread::sleep_for(10ms)) {
      if (more("1/2/7") && more("1/0/2")) return true;
    }
    return false;
  }
  /// Commands go on all the time, ten a second: reads have what is left of the rate.
  bool up_while_commanding(int& value) {
    if (const auto now = Clock::now(); now - last_command_ > 100ms) {
      last_command_ = now;
      island_->write("set proxy.knx-hall.1_0_3.actuator.percentage-1.command " + std::to_string(++value % 100) + "\n");
    }
    return value_of("proxy.knx-hall.status").find("\"up\"") != std::string::npos;
  }
  /// Until it is up, or not; how long that took.
  Clock::duration time_until(bool up, int& value) {
    const auto start = Clock::now();
    while (up_while_commanding(value) != up && Clock::now() - start < 60s) std::this_thread::sleep_for(5ms);
    return Clock::now() - start;
  }

  std::unique_ptr<Process> monitor_;
  Clock::time_point last_command_{};
};

TEST_F(KnxRestarts, SurvivesAServerThatDiesUnderTraffic) {
  const char* often = std::getenv("RUBICON_KNX_RESTARTS");
  const int rounds = often ? std::atoi(often) : 5;
  const auto pid = island_->pid();
  std::vector<double> times;
  int value = 0;
  for (int round = 1; round <= rounds; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const auto before = reads();
    knxd_->kill();
    ASSERT_LT(time_until(false, value), 60s) << "does not notice";
    knxd_->restart();
    for (int k = 0; k < 12000 && !knxd_->ready(); ++k) std::this_thread::sleep_for(5ms);
    times.push_back(std::chrono::duration<double>(time_until(true, value)).count());
    ASSERT_LT(times.back(), 60) << "does not reconnect";
    EXPECT_TRUE(asks_again(before)) << "does not read subscribed values again";
    answer(round);
    EXPECT_TRUE(becomes("proxy.knx-hall.1_2_7.sensor.temperature-1.value", temperature(round)));
    EXPECT_TRUE(becomes("proxy.knx-hall.1_0_1.actuator.switch-1.value", round % 2 ? "on" : "off"));
  }
  EXPECT_EQ(::kill(pid, 0), 0) << "the same process";
  std::sort(times.begin(), times.end());
  const auto summary = fmt::format("{} restarts: reconnected in {:.3f} s (median), {:.3f} s (worst)", rounds,
                                   times[times.size() / 2], times.back());
  RecordProperty("reconnected", summary);
  std::cout << summary << "\n";
}

}  // namespace
}  // namespace rubicon::cli
