#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <thread>

#include "examples/demo_island.h"
#include "examples/examples_in_text.h"
#include "examples/judgement.h"
#include "support/folder.h"
#include "support/private_network.h"

namespace rubicon::examples {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(ExamplesInText, OfAPageAreTheLinesOfItsCodeThatBeginWithAProgram) {
  const auto found = examples_of_page("page",
                                      "text rubicon no\n\n    $ rubicon ls    # comment\n    output\n\n"
                                      "```\nbuild/release/bin/rubicon-proxy networks\n```\nrubicon no\n"
                                      "    ./run\n    rubicon::client no;\n    rubicon-proxy check FILE\n");
  EXPECT_THAT(found, ElementsAre(Example{"page:3", "rubicon ls    # comment"},
                                 Example{"page:7", "rubicon-proxy networks"}, Example{"page:10", "./run"}));
}

TEST(ExamplesInText, OfHelpAreTheLinesBelowItsExamples) {
  EXPECT_THAT(examples_of_help("h", "rubicon [OPTIONS]\nExamples:\n  rubicon ls '6541:**' --json\n"),
              ElementsAre(Example{"h", "rubicon ls '6541:**' --json"}));
  EXPECT_THAT(examples_of_help("m", ".B rubicon\n.SH EXAMPLES\nrubicon run \\-\\-shell\n"),
              ElementsAre(Example{"m", "rubicon run --shell"}));
}

TEST(SetDecision, SeesExamplesThatHangShowNothingOrFindAProblem) {
  const auto of = [](const char* line, int code, const char* output = "", const char* errors = "") {
    return fault_of(line, {code, output, errors});
  };
  EXPECT_EQ(of("rubicon ls", 0), "");
  EXPECT_EQ(of("rubicon ls", 130), "ended with 130");
  EXPECT_EQ(of("rubicon ls", 8), "ended with 8");
  EXPECT_EQ(of("rubicon record x.rec", 130), "");
  EXPECT_EQ(of("rubicon watch", 0, "a line\n"), "");
  EXPECT_EQ(of("rubicon watch", 130, "a line\n"), "");
  EXPECT_EQ(of("rubicon watch x", 0), "shows nothing");
  EXPECT_EQ(of("rubicon top", 0), "shows nothing");
  EXPECT_EQ(of("rubicon top --rounds 1", 130, "a line\n"), "ended with 130");
  EXPECT_EQ(of("rubicon knx monitor", 130), "shows nothing");
  EXPECT_EQ(of("rubicon recorder all stop", 130), "ended with 130");
  EXPECT_EQ(of("rubicon log --follow", 130), "");
  EXPECT_EQ(of("rubicon zigbee permit --for 2min", 130), "");
  EXPECT_EQ(of("rubicon zigbee permit --for 0s", 130), "ended with 130");
  EXPECT_EQ(of("rubicon watch x y", 0, "a line\n", "rubicon: nothing fits y yet"), "names what is not there");
  EXPECT_EQ(of("curl http://x", 0, "{}"), "");
  EXPECT_EQ(of("curl http://x", 22, "{}"), "ended with 22");
  EXPECT_EQ(of("curl http://x", 0), "shows nothing");
  EXPECT_EQ(of("curl -N -H 'Accept: text/event-stream' http://x", 130, "event: set\n"), "");
  EXPECT_EQ(of("rubicon get x", 10, "", "rubicon: x is stale"), "");
  EXPECT_NE(of("rubicon get x", 10), "");
  EXPECT_EQ(of("rubicon doctor", 1, "good     line  one\nproblem  loss  one\nproblem  loss  two\n1 problem\n"), "");
  EXPECT_EQ(of("rubicon doctor", 1, "problem  loss  one\nproblem  line  two\n"), "ended with 1");
  EXPECT_EQ(of("rubicon doctor", 1, "a loss\n"), "ended with 1");
  EXPECT_EQ(of("rubicon doctor --json", 1, R"({"check":"loss","grade":"problem"})"), "");
  EXPECT_EQ(of("rubicon doctor --json", 1, R"({"check":"line","grade":"problem"})"), "ended with 1");
  EXPECT_EQ(of("rubicon doctor --interfaces eth0", 1), "");
  EXPECT_EQ(of("rubicon --engine peis doctor", 1), "");
  EXPECT_EQ(of("rubicon --engine peis ls '101:**'", 8), "");
  EXPECT_EQ(of("rubicon --engine peis ls '101:**'", 0), "ended with 0") << "where no kernel is";
  EXPECT_EQ(of("rubicon --engine peis watch '101:**'", 0), "");
  EXPECT_EQ(of("rubicon doctor --interfaces eth0", 0), "ended with 0");
}

TEST(ExamplesInText, ASynopsisIsNone) {
  for (const auto* line :
       {"rubicon-proxy run FILE [--set X]...", "rubicon COMMAND --help", "rubicon-proxy state FILE show"})
    EXPECT_TRUE(is_synopsis(line)) << line;
  for (const auto* line : {"rubicon record home.rec", "rubicon ls # FILE", "rubicon set x 'FILE'"})
    EXPECT_FALSE(is_synopsis(line)) << line;
}

/// What is not run as it stands, and why.
struct Exception {
  const char* part;  ///< of the command line
  const char* why;
};
constexpr const char* kTrust = "rubicon trust ";
constexpr Exception kNotRun[] = {
    {"192.168.1.10", "a KNX interface of somebody's house"},
    {"rubicon knx discover", "a KNX interface on a network with multicast"},
    {kTrust, "changes the trust of this host; ExamplesOfTrust runs them in a folder of its own"},
    {"/etc/rubicon/", "a file of the machine's administrator"},
    {"rubicon settings import", "changes the file of the example; ADaemonChangesItsFile"},
    {"rubicon settings undo", "the same"},
    {"| jq ", "jq need not be installed"},
    {"'Reading lamp'", "a name that people gave a point; CalledPoints.AreShownWithThem"},
    {"inbox forget", "a device that waits or is listed; Called.AForgottenDeviceIsGone"},
    {"curl -X POST", "decides about devices that other examples need; InboxOfTheApi.AListOfTheInboxIsDecidedOneByOne"},
};

/// All that is not run, besides kTrust, so that nothing is left out unseen.
std::set<std::string> not_run() {
  return {
      R"(curl -X POST -d '{"approve": ["wsn-1.7", "wsn-1.8"], "ignore": ["wsn-2.*"], "island": 6541}' http://127.0.0.1:8642/api/v1/inbox)",
      "rubicon knx discover",
      "rubicon knx discover --host 192.168.1.10    # where multicast does not arrive",
      "rubicon knx monitor --direct 192.168.1.10",
      "rubicon knx monitor --direct 192.168.1.10 --keyring hall.knxkeys --password-file hall.password",
      "rubicon knx read 1/2/7 9.001 --direct 192.168.1.10",
      "rubicon knx write 1/2/7 9.001 21.5 --direct 192.168.1.10",
      "rubicon set --json living.lamp-1 on | jq .state",
      "rubicon describe 'Reading lamp'              # a point with this name",
      "rubicon inbox forget 'Old mote'              # also a listed one: its names and values go, too",
      "rubicon settings add knx-hall '{type: knx, host: 192.168.1.10}' --groups hall.yaml",
      "rubicon settings add knx-hall '{type: knx, host: 192.168.1.10}' --groups hall.yaml --try",
      "rubicon settings add knx-hall '{type: knx, host: 192.168.1.10}' --groups hall.yaml --try   # what it would do, "
      "and the patch",
      "rubicon settings import knx-hall hall.yaml   # another group file",
      "rubicon settings import knx-hall newer.yaml     # another group file for a network that is there",
      "rubicon settings undo                           # back to the file before; again: forward",
      "rubicon settings undo                  # back to the previous file",
      "rubicon-proxy check --elsewhere /etc/rubicon/home.yaml    # the first start creates the folders",
      "rubicon-proxy check --elsewhere /etc/rubicon/home.yaml",
  };
}

/// What has to be there beside it: another component, as the text around the example says.
std::string beside(const std::string& line) {
  if (line.find("70001:robot.") != line.npos) {
    const auto key = line.substr(line.find("robot."), line.find(' ', line.find("robot.")) - line.find("robot."));
    return "rubicon publish " + key + " start --id 70001 --open";
  }
  if (line.starts_with("rubicon send 70001") || line.find("send robot") != line.npos)
    return "rubicon receive --id 70001 --name robot";
  return "";
}

/// Who changes the trust of a host is root.
std::string without_sudo(std::string text) {
  const std::string sudo = "sudo ", command = sudo + kTrust;
  for (auto at = text.find(command); at != text.npos; at = text.find(command, at)) text.erase(at, sudo.size());
  return text;
}

std::vector<Example> all_examples() {
  std::vector<Example> all;
  const auto add = [&all](std::vector<Example> more) { std::move(more.begin(), more.end(), std::back_inserter(all)); };
  const fs::path source = RUBICON_SOURCE_DIR;
  add(examples_of_page("README.md", read_text(source / "README.md")));
  std::vector<fs::path> pages;
  for (const auto& page : fs::directory_iterator(source / "docs")) {
    if (page.path().extension() == ".md") pages.push_back(page.path());
  }
  std::sort(pages.begin(), pages.end());
  for (const auto& page : pages)
    add(examples_of_page("docs/" + page.filename().string(), without_sudo(read_text(page))));
  for (const auto* page : {"src/networks/salad/README.md", "examples/recordings/README.md"})
    add(examples_of_page(page, read_text(source / page)));
  add(examples_of_help("rubicon-proxy(1)", read_text(source / "packaging/man/rubicon-proxy.1")));
  // rubicon(1) is made of what --help of each command says.
  const auto manual = support::run_to_end({RUBICON_BINARY_DIR "/bin/rubicon", "manual"});
  add(examples_of_help("rubicon(1)", without_sudo(manual.output)));
  all.push_back({"examples/client/4_points.cpp", "example-4_points temperature"});
  all.push_back({"examples/client/5_known_island.cpp", "example-5_known_island 6541 living"});
  add(examples_of_help("rubicon --help", support::run_to_end({RUBICON_BINARY_DIR "/bin/rubicon", "--help"}).output));
  for (const auto& words : std::vector<std::vector<std::string>>{{"trust"}, {"trust", "dds"}, {"trust", "broker"}}) {
    auto command = words;
    command.insert(command.begin(), RUBICON_BINARY_DIR "/bin/rubicon");
    command.emplace_back("--help");
    add(examples_of_help("rubicon trust --help", without_sudo(support::run_to_end(command).output)));
  }
  return all;
}

const char* reason_not_to_run(const Example& example) {
  for (const auto& exception : kNotRun) {
    if (example.line.find(exception.part) != example.line.npos) return exception.why;
  }
  return nullptr;
}

/// `./run` builds first and then runs this. Islands and components with an id run in a space of their own, motes, SALAD
/// and pages on another port: those of the example are the demo's. Answers of curl end as lines do.
std::string runnable(const std::string& line, std::size_t domain) {
  if (line.starts_with("motes-simulator --motes")) return "motes-simulator --port 19303" + line.substr(15);
  if (line.starts_with("salad-simulator ")) return line + " --listen 19000";
  if (line.starts_with("knx-simulator ")) return line.substr(0, line.find(" --listen")) + " --listen 19671";
  if (line.starts_with("curl ")) return R"(curl --silent --show-error --fail-with-body -w '\n')" + line.substr(4);
  if (line.starts_with("rubicon web") && line.find("--listen") == line.npos)
    return "rubicon web --listen 127.0.0.1:18642" + line.substr(11);
  if (line.starts_with("zigbee-simulator ")) return line + " --base other";  // the demo's bridge is on that broker
  auto command = line;
  if (line.starts_with("./run")) {
    const auto rest = line.substr(0, line.find(" #")).substr(5);
    const auto argument = rest.find_first_not_of(' ');
    const bool named = argument != rest.npos && rest[argument] != '-';
    command = "rubicon-proxy run" + (named ? rest : " examples/home.yaml" + rest);
  }
  const auto comment = command.find(" #");
  if (command.starts_with("rubicon-proxy run"))
    command = command.substr(0, comment) + " --set tuples.space=s" + std::to_string(domain);
  if (command.starts_with("rubicon receive --id")) command += " --space s" + std::to_string(domain);
  return command;
}

constexpr std::size_t kParts = 4;  ///< of the examples, which run at the same time

std::string page_of(const Example& example) {
  return example.place.substr(0, example.place.rfind(':'));
}

/// A page stays together: its examples use the files of those before them.
std::size_t begin_of(const std::vector<Example>& all, std::size_t part) {
  auto at = all.size() * part / kParts;
  while (at > 0 && at < all.size() && page_of(all[at]) == page_of(all[at - 1])) ++at;
  return at;
}

/// An example that runs until it is interrupted: it has time to show something, or ten seconds if it shows nothing.
class Endless {
 public:
  Endless(const DemoIsland& demo, const std::string& line)
      : shows_(shows_what_is_there(line)), process_(demo.command(line, 120)) {}

  void wait() {
    if (!shows_) return std::this_thread::sleep_until(begun_ + std::chrono::seconds(10));
    if (const auto first = process_.line()) outcome_.output = *first + "\n";
  }
  void interrupt() const { process_.signal(SIGINT); }
  support::Outcome ended() {
    while (const auto line = process_.line()) outcome_.output += *line + "\n";
    outcome_.code = process_.exit_code();
    outcome_.errors = process_.errors();
    return outcome_;
  }

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  bool shows_;
  support::Process process_;
  support::Outcome outcome_;
};

/// The demo island and a part of the examples, run beside it.
class EveryExample : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    if (!demo_.reason().empty()) GTEST_SKIP() << demo_.reason();
  }

  static void judge(const Example& example, const support::Outcome& outcome) {
    EXPECT_EQ(fault_of(runnable(example.line, 0), outcome), "") << example.place << ": " << example.line << "\n"
                                                                << outcome.output.substr(0, 4000) << outcome.errors;
  }

  support::Outcome run(const Example& example) const {
    std::unique_ptr<support::Process> other;
    if (const auto line = beside(example.line); !line.empty()) {
      other = std::make_unique<support::Process>(demo_.command(line, kLong));
      while (support::run_to_end(demo_.command("rubicon islands --all | grep -q 70001", kLong)).code != 0) {
        if (!testing::Test::HasFailure() && ++waited_ > 50) ADD_FAILURE() << line << " is not there";
        if (waited_ > 50) break;
      }
    }
    const auto outcome = support::run_to_end(demo_.command(runnable(example.line, 9), kLong));
    if (other) other->signal(SIGTERM);
    if (other) other->exit_code();
    return outcome;
  }

  static constexpr int kLong = 120;  ///< in seconds
  static constexpr std::size_t kAtATime = 8;
  DemoIsland demo_;
  mutable int waited_ = 0;
};

TEST(AllExamples, AreRunButThese) {
  std::size_t run_to_end = 0, run_for_a_while = 0;
  std::set<std::string> skipped;
  for (const auto& example : all_examples()) {
    if (reason_not_to_run(example)) {
      if (example.line.find(kTrust) == example.line.npos) skipped.insert(example.line);
    } else {
      ++(is_endless(runnable(example.line, 0)) ? run_for_a_while : run_to_end);
    }
  }
  EXPECT_GT(run_to_end, 50U);
  EXPECT_GT(run_for_a_while, 12U);
  EXPECT_EQ(skipped, not_run());
}

TEST_P(EveryExample, EndsAsItShould) {
  std::vector<Example> endless;  // those in a row run at the same time
  std::size_t run_for_a_while = 0;
  const auto run_endless = [&] {
    std::vector<std::unique_ptr<Endless>> running;
    for (const auto& example : endless)
      running.push_back(std::make_unique<Endless>(demo_, runnable(example.line, 10 + run_for_a_while++)));
    for (auto& one : running) one->wait();
    for (auto& one : running) one->interrupt();
    for (std::size_t i = 0; i < endless.size(); ++i) judge(endless[i], running[i]->ended());
    endless.clear();
  };
  const auto all = all_examples();
  for (auto i = begin_of(all, GetParam()); i < begin_of(all, GetParam() + 1); ++i) {
    if (reason_not_to_run(all[i])) continue;
    if (is_endless(runnable(all[i].line, 0))) {
      endless.push_back(all[i]);
      if (endless.size() == kAtATime) run_endless();
    } else {
      run_endless();
      judge(all[i], run(all[i]));
    }
  }
  run_endless();
}
INSTANTIATE_TEST_SUITE_P(Part, EveryExample, testing::Range(std::size_t{0}, kParts));

/// An example of trust, and what it needs where there is no terminal, no running island and no other host.
struct TrustExample {
  std::string line, more{}, before{};
};
const std::vector<TrustExample> kTrustExamples{
    {"rubicon trust init --broker broker.example.org"},
    {"rubicon trust init --name Hall", "--realm ./hall"},
    {"rubicon trust broker mosquitto", "--out broker"},
    {"rubicon trust broker mosquitto --broker broker.example.org", "--out broker"},
    {"rubicon trust broker mosquitto --passwords", "--out broker"},
    {"rubicon trust add hall --island 6541", "--phrase-file hall.phrase"},
    {"rubicon trust add desk --role admin", "--phrase-file desk.phrase"},
    {"rubicon trust add panel --password", "--phrase-file panel.phrase"},
    {"rubicon trust show", "--realm ./realm"},
    {"rubicon trust show --json"},
    {"rubicon trust join hall.trust", "--yes --phrase-file hall.phrase --realm ./there"},
    {"rubicon trust join desk.trust", "--yes --phrase-file desk.phrase --realm ./laptop"},
    {"rubicon trust join desk.trust --yes < phrase", "--realm ./other", "cp desk.phrase phrase"},
    {"rubicon trust change hall --role ops --role alarm"},
    {"rubicon trust change hall --no-islands"},
    {"rubicon trust renew hall", "", "rm hall.trust"},
    {"rubicon trust renew hall --new-key", "--phrase-file hall.again", "rm hall.trust"},
    {"rubicon trust revoke hall"},
    {"rubicon trust revoke desk", "", "rm *.trust phrase *.phrase"},
    {"rubicon trust may desk read proxy.hall.door.status --config /etc/rubicon/home.yaml"},
    {"rubicon trust may desk set proxy.hall.door.actuator.lock-1.command", "--config home.yaml"},
    {"rubicon trust may panel approve proxy.inbox.hall.command", "--config home.yaml"},
    {"rubicon trust audit", "--config home.yaml"},
    {"rubicon trust audit --name desk --refused", "--config home.yaml"},
    {"rubicon trust audit --follow --json", "--config home.yaml | head -n 1"},
};

std::string without_comment(const std::string& line) {
  const auto command = line.substr(0, line.find(" #"));
  return command.substr(0, command.find_last_not_of(' ') + 1);
}

TEST(ExamplesOfTrust, EndWellOneAfterTheOther) {
  const support::PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  const support::Folder folder;
  std::ofstream(folder / "home.yaml") << "island: {id: 1}\nrights:\n  - {who: [desk, panel], may: all}\n"
                                         "audit: {file: home.audit}\n";
  std::ofstream(folder / "home.audit") << R"({"t":1767225600,"who":"desk","verdict":"refused"})"
                                       << "\n";
  std::set<std::string> run;
  for (const auto& [line, more, before] : kTrustExamples) {
    auto command = "cd " + folder.path() + "; " + (before.empty() ? "" : before + "; ") + line + " " + more;
    if (const auto at = command.find("/etc/rubicon/"); at != command.npos) command.erase(at, 13);
    const auto outcome = support::run_to_end(
        {"env", "RUBICON_REALM=realm", "PATH=" RUBICON_BINARY_DIR "/bin:/usr/bin:/bin", "sh", "-c", command});
    EXPECT_EQ(outcome.code, 0) << command << "\n" << outcome.errors;
    run.insert(line);
  }
  std::set<std::string> expected;
  for (const auto& example : all_examples()) {
    if (example.line.find(kTrust) != example.line.npos) expected.insert(without_comment(example.line));
  }
  EXPECT_EQ(run, expected);
}

}  // namespace
}  // namespace rubicon::examples
