#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <set>

#include "apps/rubicon/live_island.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Two islands in a network of their own, for all tests: 6541 has what is commanded, 7 has many devices.
class CommandLine : public testing::Test {
 protected:
  struct World {
    PrivateNetwork alone;
    Folder folder;
    std::unique_ptr<Process> home, many;
  };

  static std::string home_text() {
    return R"(island: {id: 6541, name: home}
discovery: {rules: [{network: dummy-new, new-devices: ask}]}
networks:
  dummy-1:
    type: dummy
    simulate:
      hall:
        name: Front hall
        sensors: {temperature-1: {wave: sine, low: 10, high: 30, period: 5s}}
        actuators:
          switch-1: {}
          switch-2: {behaviour: ignore}
          switch-3: {behaviour: fail}
          switch-4: {delay: 4500ms}
          dimmer-1: {behaviour: silent}
  dummy-away:
    type: dummy
    line: {down-at: 100ms}
    simulate: {barn: {actuators: {lock-1: {}}}}
  dummy-new:
    type: dummy
    simulate: {guest: {name: A guest}, stranger: {}, other: {}}
)";
  }
  static std::string many_text() {
    std::string text = "island: {id: 7, name: many}\nnetworks:\n  dummy-many:\n    type: dummy\n    simulate:\n";
    for (int i = 0; i < 25; ++i) text += "      room" + std::to_string(i) + ": {sensors: {motion-1: {}}}\n";
    return text;
  }

  static void SetUpTestSuite() {
    world_ = std::make_unique<World>();
    if (!world_->alone.entered()) return;
    world_->home = started(world_->folder.write("home.yaml", home_text()), {"--set", "tuples.engine=dds"});
    world_->many = started(world_->folder.write("many.yaml", many_text()), {"--set", "tuples.engine=dds"});
  }
  static void TearDownTestSuite() { world_.reset(); }
  void SetUp() override {
    if (!world_->alone.entered()) GTEST_SKIP() << world_->alone.reason();
  }

  static std::string file(const std::string& name) { return world_->folder.file(name); }
  static std::unique_ptr<World> world_;
};
std::unique_ptr<CommandLine::World> CommandLine::world_;

TEST_F(CommandLine, ListsIslands) {
  const auto table = rubicon({"islands"});
  EXPECT_EQ(table.code, 0) << table.errors;
  EXPECT_THAT(table.output, StartsWith("ID "));
  EXPECT_THAT(table.output, HasSubstr("\n6541"));
  const auto lines = lines_of(rubicon({"--json", "islands"}));
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0]["id"], 7);
  EXPECT_EQ(lines[1]["id"], 6541);
  EXPECT_EQ(lines[1]["name"], "home");
  EXPECT_EQ(lines[0]["networks"]["dummy-many"], 25);
  EXPECT_EQ(lines[0]["devices"], 25);
}

TEST_F(CommandLine, ListsTuplesWithQuality) {
  const auto table = rubicon({"ls", "proxy.dummy-1.hall.actuator.*.value"});
  EXPECT_EQ(table.code, 0) << table.errors;
  EXPECT_THAT(table.output, StartsWith("TUPLE"));
  EXPECT_THAT(table.output, HasSubstr("6541:proxy.dummy-1.hall.actuator.dimmer-1.value"));
  EXPECT_THAT(table.output, Not(HasSubstr("\x1b")));
  const auto lines = lines_of(rubicon({"ls", "hall.temperature-1", "--json"}));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0]["key"], "proxy.dummy-1.hall.sensor.temperature-1.value");
  EXPECT_TRUE(lines[0].contains("quality"));
  const auto nothing = rubicon({"ls", "proxy.nothing.**"});
  EXPECT_EQ(nothing.code, 8);
  EXPECT_THAT(nothing.errors,
              testing::ContainsRegex("no tuple matches proxy.nothing.\\*\\* .looked in folder .*; 2 islands present."));
  EXPECT_EQ(rubicon({"ls", "a..b"}).code, 2);
}

TEST_F(CommandLine, ShowsTheTree) {
  const auto tree = rubicon({"tree", "--island", "6541"});
  EXPECT_EQ(tree.code, 0) << tree.errors;
  EXPECT_THAT(tree.output, HasSubstr("─ hall  Front hall"));
  EXPECT_THAT(tree.output, HasSubstr("─ temperature-1"));
  const auto lines = lines_of(rubicon({"tree", "--json", "--network", "dummy-1"}));
  ASSERT_GE(lines.size(), 1U);
  EXPECT_TRUE(lines.back()["networks"]["dummy-1"]["hall"].contains("switch-1")) << lines.back();
}

TEST_F(CommandLine, GetsOneTuple) {
  EXPECT_EQ(rubicon({"get", "6541:proxy.networks"}).output, "[\"dummy-1\",\"dummy-away\",\"dummy-new\"]\n");
  const auto all = rubicon({"get", "--all", "7:proxy.networks"});
  EXPECT_THAT(all.output, HasSubstr("creator    7 (many)\n"));
  EXPECT_THAT(all.output, HasSubstr("media type application/json\n"));
  const auto line = lines_of(rubicon({"get", "--json", "7:proxy.networks"})).at(0);
  EXPECT_EQ(line["seq"], 1);
  EXPECT_EQ(line["mimetype"], "application/json");
}

TEST_F(CommandLine, GetNamesTheCandidatesOrSaysThatNothingIsThere) {
  const auto both = rubicon({"get", "proxy.networks"});
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.errors, HasSubstr("7:proxy.networks\n"));
  EXPECT_THAT(both.errors, HasSubstr("6541:proxy.networks"));
  EXPECT_EQ(rubicon({"get", "6541:proxy.nothing"}).code, 8);
  EXPECT_EQ(rubicon({"get", "proxy.*"}).code, 2);
  EXPECT_EQ(rubicon({"get"}).code, 2);
}

TEST_F(CommandLine, AFreshValueWakesTheSensor) {
  const auto fresh = rubicon({"get", "--fresh", "hall.temperature-1", "--patience", "10s"});
  EXPECT_EQ(fresh.code, 0) << fresh.errors;
  EXPECT_GE(std::stod("0" + fresh.output), 10);
}

TEST_F(CommandLine, ACommandEndsWithTheWordOfItsStatus) {
  const auto good = rubicon({"set", "hall.switch-1", "on"});
  EXPECT_EQ(good.code, 0) << good.errors;
  EXPECT_THAT(good.output, StartsWith("6541:proxy.dummy-1.hall.actuator.switch-1.command confirmed after"));
  const auto assumed = rubicon({"set", "--json", "6541:proxy.dummy-1.hall.actuator.dimmer-1.command", "30"});
  EXPECT_EQ(assumed.code, 0);
  EXPECT_EQ(lines_of(assumed).at(0)["state"], "assumed");
  const auto refused = rubicon({"set", "hall.switch-1", "maybe"});
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.output, HasSubstr("'maybe' is not one of off, on"));
  const auto failed = rubicon({"set", "hall.switch-3", "on"});
  EXPECT_EQ(failed.code, 4);
  EXPECT_THAT(failed.output, HasSubstr(" failed after"));
}

TEST_F(CommandLine, ACommandThatIsNotDoneHasACodeForTheReason) {
  Process ignored({kProgram, "set", "hall.switch-2", "on", "--json"});
  Process waits({kProgram, "set", "barn.lock-1", "on", "--ttl", "300ms", "--json"});
  Process status({kProgram, "watch", "proxy.dummy-1.hall.actuator.switch-4.status", "--passive", "--json"});
  ASSERT_TRUE(status.line()) << status.errors();
  Process first({kProgram, "set", "hall.switch-4", "on", "--json"});
  ASSERT_TRUE(status.line_with("\\\"state\\\":\\\"sent\\\"")) << status.errors();
  Process second({kProgram, "set", "hall.switch-4", "off", "--ttl", "3s", "--wait", "10ms", "--json"});
  EXPECT_EQ(first.exit_code(), 7) << first.errors();
  EXPECT_EQ(second.exit_code(), 0) << "it was sent within its time to live, and the island waits for the report"
                                   << second.line().value_or(second.errors());
  EXPECT_EQ(waits.exit_code(), 6) << waits.line().value_or(waits.errors());
  EXPECT_EQ(ignored.exit_code(), 5) << ignored.line().value_or(ignored.errors());
}

TEST_F(CommandLine, WhoIsNotThereCannotBeSet) {
  const auto owner = rubicon({"set", "77:proxy.a.b.actuator.c-1.command", "on"});
  EXPECT_EQ(owner.code, 8);
  EXPECT_THAT(owner.output, HasSubstr("no-such-owner"));
  EXPECT_EQ(rubicon({"set", "6541:proxy.a.b.actuator.c-1.command", "on"}).code, 8);
  EXPECT_EQ(rubicon({"set", "nobody.switch-1", "on"}).code, 8);
  EXPECT_EQ(rubicon({"set", "proxy.networks", "x"}).code, 2);
  EXPECT_EQ(rubicon({"set", "hall.switch-1", "on", "--ttl", "5"}).code, 2);
}

TEST_F(CommandLine, WatchShowsEventsAsTheyCome) {
  Process lines({kProgram, "watch", "hall.temperature-1", "--min-interval", "50ms", "--count", "5", "--json"});
  double last = 0;
  for (int i = 0; i < 5; ++i) {
    const auto line = json::parse(lines.line().value_or(""), nullptr, false);
    ASSERT_TRUE(line.is_object()) << lines.errors();
    EXPECT_EQ(line["event"], "set");
    EXPECT_GE(line["seq"].get<double>(), last);
    last = line["seq"].get<double>();
  }
  EXPECT_EQ(lines.exit_code(), 0);
  const auto text = rubicon({"watch", "hall.temperature-1", "--count", "1"});
  EXPECT_THAT(text.output, HasSubstr("6541:proxy.dummy-1.hall.sensor.temperature-1.value = "));
}

TEST_F(CommandLine, WatchEndsAfterItsTimeAndHoldsBackWhatDoesNotChange) {
  const auto changes = rubicon(
      {"watch", "hall.rate", "--for", "4s", "--max-interval", "50ms", "--dead-band", "1000", "--changes", "--passive"});
  EXPECT_EQ(changes.code, 0) << changes.errors;
  EXPECT_EQ(std::count(changes.output.begin(), changes.output.end(), '\n'), 1) << changes.output;
  const auto beats = rubicon({"watch", "6541:proxy.networks", "--count", "5", "--max-interval", "50ms"});
  EXPECT_EQ(std::count(beats.output.begin(), beats.output.end(), '\n'), 5) << beats.output;
}

TEST_F(CommandLine, WatchSaysWhenItWakesManyDevices) {
  Process many({kProgram, "watch", "7:proxy.*.*.sensor.*.value"});
  for (int i = 0; i < 3000 && many.errors().empty(); ++i) ::usleep(20'000);
  EXPECT_THAT(many.errors(), HasSubstr("wakes the sensors of 25 devices"));
  const auto passive = rubicon({"watch", "7:proxy.*.*.sensor.*.value", "--count", "1", "--passive"});
  EXPECT_EQ(passive.errors, "");
  const auto few = rubicon({"watch", "6541:proxy.*.*.sensor.*.value", "--count", "1"});
  EXPECT_EQ(few.errors, "");
}

TEST_F(CommandLine, ASignalEndsAWatchWithASummary) {
  Process watch({kProgram, "watch", "6541:proxy.networks"});
  ASSERT_TRUE(watch.line_with("proxy.networks"));
  watch.signal(SIGINT);
  EXPECT_EQ(watch.exit_code(), 0);
  EXPECT_THAT(watch.errors(), HasSubstr("1 event of 1 tuple in "));
}

TEST_F(CommandLine, AReaderThatGoesEndsAWatchQuietly) {
  Process watch({kProgram, "watch", "6541:proxy.networks"});
  ASSERT_TRUE(watch.line_with("proxy.networks"));
  watch.close_output();
  EXPECT_EQ(watch.exit_code(), 0);
  EXPECT_EQ(watch.errors(), "");
}

TEST_F(CommandLine, ListsDevicesByWhatTheyHave) {
  const auto table = rubicon({"devices", "--type", "temperature"});
  EXPECT_EQ(table.code, 0) << table.errors;
  EXPECT_THAT(table.output, HasSubstr("6541:proxy.dummy-1.hall  Front hall  reachable"));
  EXPECT_THAT(table.output, Not(HasSubstr("room1")));
  EXPECT_EQ(lines_of(rubicon({"devices", "--network", "dummy-m*", "--json"})).size(), 25U);
  EXPECT_EQ(lines_of(rubicon({"devices", "--island", "7", "--name", "room7", "--json"})).at(0)["key"],
            "proxy.dummy-many.room7");
  EXPECT_EQ(rubicon({"devices", "--type", "unheardof"}).code, 8);
}

TEST_F(CommandLine, DescribesADevice) {
  const auto text = rubicon({"describe", "Front hall"});
  EXPECT_EQ(text.code, 0) << text.errors;
  EXPECT_THAT(text.output, HasSubstr("device   6541:proxy.dummy-1.hall\n"));
  EXPECT_THAT(text.output, HasSubstr("temperature-1"));
  EXPECT_THAT(text.output, HasSubstr("-273.15..2000"));
  const auto line = lines_of(rubicon({"describe", "dummy-1.hall", "--json"})).at(0);
  EXPECT_EQ(line["points"].at(0)["id"], "temperature-1");
  EXPECT_EQ(rubicon({"describe", "nobody"}).code, 8);
}

TEST_F(CommandLine, DecidesAboutWhoWaits) {
  const auto waiting = rubicon({"inbox"});
  EXPECT_EQ(waiting.code, 0) << waiting.errors;
  EXPECT_THAT(waiting.output, testing::ContainsRegex("dummy-new.guest +A guest"));
  EXPECT_EQ(lines_of(rubicon({"inbox", "--json", "--island", "6541"})).size(), 3U);
  const auto approved = rubicon({"inbox", "approve", "dummy-new.guest"});
  EXPECT_EQ(approved.code, 0) << approved.errors;
  EXPECT_EQ(approved.output, "approved dummy-new.guest\n");
  EXPECT_EQ(lines_of(rubicon({"inbox", "ignore", "dummy-new.s*", "--island", "6541", "--json"})).at(0)["state"],
            "applied");
  EXPECT_EQ(rubicon({"devices", "--name", "guest"}).code, 0);
  auto left = rubicon({"inbox"});  // the island publishes the list a little later
  for (int i = 0; i < 100 && left.output.find("ignored") == std::string::npos; ++i) left = rubicon({"inbox"});
  EXPECT_THAT(left.output, HasSubstr("dummy-new.other"));
  EXPECT_THAT(left.output, HasSubstr("1 device ignored"));
  EXPECT_EQ(rubicon({"inbox", "approve", "dummy-new.nobody"}).code, 2);  // which island is not said
  EXPECT_EQ(rubicon({"inbox", "approve"}).code, 2);
  EXPECT_EQ(rubicon({"inbox", "shout", "x"}).code, 2);
}

/// A component in this process.
class Friend {
 public:
  Friend() {
    client::Options options;
    options.name = "friend";
    client_ = std::move(*Client::open(options));
  }
  Client& client() { return *client_; }
  /// Runs its loop until the program ended.
  Outcome while_it_runs(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kProgram);
    Process process(std::move(arguments));
    process.close_input();
    // The end of its output is the end of it.
    const auto pid = process.pid();
    client_->run_until([pid] { return ::kill(pid, 0) != 0 || ended(pid); }, 60s);
    Outcome outcome;
    while (const auto line = process.line()) outcome.output += *line + "\n";
    outcome.code = process.exit_code();
    outcome.errors = process.errors();
    return outcome;
  }

 private:
  static bool ended(pid_t pid) {
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::string text;
    std::getline(file, text);
    return text.empty() || text.find(") Z ") != text.npos;
  }
  std::unique_ptr<Client> client_;
};

TEST_F(CommandLine, SendsToThoseWhoWaitForTheType) {
  Friend other;
  std::vector<std::string> heard;
  const auto letters =
      other.client().on_message("chat", [&](const client::UserMessage& message) { heard.push_back(message.bytes); });
  const auto id = std::to_string(number(other.client().id()));
  const auto sent = other.while_it_runs({"send", id, "--type", "chat", "hello"});
  EXPECT_EQ(sent.code, 0) << sent.errors;
  EXPECT_THAT(sent.output, StartsWith("sent 5 bytes to " + id));
  const auto file = world_->folder.write("letter", "from a file");
  EXPECT_TRUE(
      lines_of(other.while_it_runs({"send", "friend", "--type", "chat", "--file", file, "--json"})).at(0)["ok"]);
  EXPECT_THAT(heard, ElementsAre("hello", "from a file"));
  const auto unheard = rubicon({"send", "6541", "--type", "chat", "-"}, "from standard input");
  EXPECT_EQ(unheard.code, 3);
  EXPECT_THAT(unheard.errors, HasSubstr("island 6541 has no listener"));
  const auto hex = other.while_it_runs({"send", id, "--type", "chat", "--hex", "68 69"});
  EXPECT_EQ(hex.code, 0) << hex.errors;
  EXPECT_EQ(heard.back(), "hi");
  EXPECT_EQ(rubicon({"send", id, "--hex", "6x"}).code, 2);
  EXPECT_EQ(rubicon({"send", "77", "x"}).code, 8);
  EXPECT_EQ(rubicon({"send", "6541"}).code, 2);
  EXPECT_EQ(rubicon({"send", "6541", "--file", "/nonexistent"}).code, 1);
}

TEST_F(CommandLine, SendsToADeviceWhereverItIsOnTheIsland) {
  const auto nowhere = rubicon({"send", "6541", "--device", "nowhere", "x"});
  EXPECT_EQ(nowhere.code, 3);
  EXPECT_THAT(nowhere.errors, HasSubstr("no network of island 6541 has a device 'nowhere'"));
  const auto found = rubicon({"send", "6541", "--device", "hall", "x"});
  EXPECT_EQ(found.code, 3);
  EXPECT_THAT(found.errors, HasSubstr("simulated devices take no opaque"));
  EXPECT_THAT(rubicon({"send", "6541", "--device", "hall", "--network", "none", "x"}).errors,
              HasSubstr("no network none"));
}

TEST_F(CommandLine, AppendsAndDeletesWhatItsOwnerLetsGo) {
  Friend other;
  auto& space = other.client().tuples();
  ASSERT_TRUE(space.set("robot.diary", "one"));
  const auto policy = space.add_policy(
      Pattern::parse("robot.**").value(), [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
      tuples::PolicyScope::kSetsAndAppends);
  const auto id = std::to_string(number(other.client().id()));
  const auto appended = other.while_it_runs({"append", id + ":robot.diary", ", two"});
  EXPECT_EQ(appended.code, 0) << appended.output << appended.errors;
  EXPECT_EQ(space.get(other.client().id(), "robot.diary")->value, "one, two");
  const auto deleted = other.while_it_runs({"delete", "robot.diary", "--json"});
  EXPECT_EQ(deleted.code, 0) << deleted.output << deleted.errors;
  EXPECT_EQ(lines_of(deleted).at(0)["state"], "applied");
  EXPECT_TRUE(other.client().run_until([&] { return !space.get(other.client().id(), "robot.diary"); }, 60s));
  EXPECT_EQ(rubicon({"append", "6541:proxy.networks", "x"}).code, 3);
  EXPECT_EQ(rubicon({"delete", "6541:proxy.networks"}).code, 3);
}

TEST_F(CommandLine, RecordsWhatTheDaemonsToolReads) {
  const auto made = rubicon({"record", file("home.rec"), "--island", "6541", "--for", "2s"});
  EXPECT_EQ(made.code, 0) << made.errors;
  EXPECT_THAT(made.output, HasSubstr(" written"));
  const auto told = support::run_to_end({kDaemon, "recording", file("home.rec"), "info"});
  EXPECT_EQ(told.code, 0) << told.errors;
  EXPECT_THAT(told.output, HasSubstr("6541"));
  const auto exported =
      support::run_to_end({kDaemon, "recording", file("home.rec"), "export", "--pattern", "proxy.networks"});
  EXPECT_THAT(exported.output, HasSubstr(",6541,proxy.networks,"));
  const auto two = rubicon({"record", file("other.rec"), "--for", "1s"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.errors, HasSubstr("choose it with --island: 7 6541"));
  EXPECT_EQ(rubicon({"record", "/nonexistent/x.rec", "--island", "7", "--for", "1s"}).code, 1);
}

TEST_F(CommandLine, ARecordingEndsWithASignal) {
  Process record({kProgram, "record", file("signal.rec"), "7:proxy.networks", "--island", "7", "--json"});
  const auto has_records = [] { return std::filesystem::file_size(file("signal.rec")) > 150; };
  for (int i = 0; i < 3000 && !(std::filesystem::exists(file("signal.rec")) && has_records()); ++i) ::usleep(20'000);
  record.signal(SIGTERM);
  const auto line = json::parse(record.line().value_or(""), nullptr, false);
  EXPECT_EQ(record.exit_code(), 0) << record.errors();
  EXPECT_GE(line.value("records", 0), 2);
}

TEST_F(CommandLine, TopCountsWhatHappens) {
  Process waker({kProgram, "watch", "hall.temperature-1", "--min-interval", "100ms"});
  ASSERT_TRUE(waker.line());
  std::vector<json> lines;
  for (int i = 0; i < 20 && lines.empty(); ++i)
    lines = lines_of(rubicon(
        {"top", "6541:proxy.*.*.sensor.*.value", "--by", "device", "--rounds", "1", "--interval", "2s", "--json"}));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0]["device"], "6541:proxy.dummy-1.hall");
  EXPECT_GT(lines[0]["per_second"].get<double>(), 0);
  EXPECT_THAT(lines[0]["time"].is_string() ? lines[0]["time"].get<std::string>() : lines[0].dump(),
              testing::MatchesRegex("[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}\\.[0-9]{6}[+-][0-9]{2}:[0-9]{2}"));
  const auto table = rubicon({"top", "--rounds", "1", "--interval", "500ms"});
  EXPECT_EQ(table.code, 0);
  EXPECT_THAT(table.output, HasSubstr("PER SECOND"));
}

TEST_F(CommandLine, CompletesLiveKeysAndDevices) {
  EXPECT_THAT(completed({"get", "6541:proxy.dummy-1."}).output, HasSubstr("6541:proxy.dummy-1.hall."));
  EXPECT_THAT(completed({"set", "hall.sw"}).output, HasSubstr("hall.switch-1\n"));
  EXPECT_THAT(completed({"describe", "room2"}).output, HasSubstr("room24\n"));
  EXPECT_THAT(completed({"send", "65"}).output, HasSubstr("6541\n"));
  EXPECT_EQ(completed({"rec"}).output, "receive\nrecord\nrecorder\n");
}

TEST_F(CommandLine, TheBashCompletionCompletes) {
  const auto outcome = support::run_to_end(
      {"env", "RUBICON_PATIENCE=30s", "bash", "-c",
       "PATH=" RUBICON_BINARY_DIR "/bin:$PATH; . <(rubicon completion bash); COMP_LINE='rubicon get 6541:proxy.netw'; "
       "COMP_POINT=${#COMP_LINE}; compopt() { :; }; _rubicon; printf '%s\\n' \"${COMPREPLY[@]}\""});
  EXPECT_EQ(outcome.output, "proxy.networks\n") << outcome.errors;  // what stands behind the colon
}

TEST_F(CommandLine, TakesItsPlaceFromEnvironmentAndConfiguration) {
  const auto elsewhere = support::run_to_end({"env", "RUBICON_DOMAIN=9", kProgram, "islands", "--engine", "dds"});
  EXPECT_EQ(elsewhere.code, 8);
  EXPECT_THAT(elsewhere.errors,
              HasSubstr("no island (looked in domain 9 on lo; 0 islands present); run `rubicon doctor`"));
  const auto apart = support::run_to_end({"env", "RUBICON_SPACE=lab", kProgram, "islands"});
  EXPECT_EQ(apart.code, 8);
  EXPECT_THAT(apart.errors, HasSubstr(", space lab; 0 islands present); run `rubicon doctor`"));
  const auto old = support::run_to_end({"env", "RUBICON_TAG=lab", kProgram, "islands"});
  EXPECT_THAT(old.errors, HasSubstr("they are the space d0-lab of this host, expected space: d0-lab"));
  const auto config =
      world_->folder.write("far.yaml", small_island(9, "{engine: dds, host: no, domain: 11, tag: far}"));
  EXPECT_THAT(rubicon({"islands", "--config", config}).errors, HasSubstr("domain 11 on lo, tag far"));
  EXPECT_THAT(rubicon({"islands", "--config", config, "--domain", "12"}).errors, HasSubstr("domain 12 on lo, tag far"));
  const auto near = world_->folder.write("near.yaml", small_island(9, "{space: near}"));
  EXPECT_THAT(rubicon({"islands", "--config", near}).errors, HasSubstr(", space near;"));
  EXPECT_EQ(rubicon({"islands", "--config", file("absent.yaml")}).code, 2);
  EXPECT_EQ(rubicon({"islands", "--domain", "1000"}).code, 2);
  EXPECT_EQ(rubicon({}).code, 2);
  EXPECT_EQ(rubicon({"islands", "--interfaces", "nope0"}).code, 1);
}

TEST_F(CommandLine, EachCommandHasHelpWithExamples) {
  for (const auto* command :
       {"islands",  "networks", "ls",   "tree",    "get",     "set",   "append", "delete", "watch",  "devices",
        "describe", "inbox",    "send", "receive", "publish", "types", "record", "top",    "doctor", "completion"}) {
    const auto help = rubicon({command, "--help"});
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_THAT(help.output, HasSubstr("Examples:\n  ")) << command;
  }
  EXPECT_THAT(rubicon({"--help"}).output, HasSubstr("5 timed-out"));
  EXPECT_THAT(rubicon({"manual"}).output, HasSubstr(".SS watch"));
}

}  // namespace
}  // namespace rubicon::cli
