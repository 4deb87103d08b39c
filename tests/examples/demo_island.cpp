#include "examples/demo_island.h"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "support/keyring_writer.h"
#include "support/knx_project.h"

namespace rubicon::examples {

namespace fs = std::filesystem;

namespace {

const std::string kPrograms = RUBICON_BINARY_DIR "/bin";
const std::string kExamples = RUBICON_SOURCE_DIR "/examples";

// As in ./run.
const std::string kMotes =
    "networks.wsn-flat={type: wsn, source: \"network@127.0.0.1:19202\", board: EM1000, sampling: read-updates, "
    "actuators: assumed}";
const std::string kKnx =
    "networks.knx-demo={type: knx, host: 127.0.0.1, port: 13671, groups: {1/0/1: {dpt: 1.001, kind: actuator, state: "
    "1/0/2, name: Hall lamp}, 1/2/7: {dpt: 9.001, name: Hall temperature}, 1/2/8: {dpt: 9.007, name: Hall humidity}}}";
const std::string kZigbee = "networks.zigbee={type: zigbee, broker: \"127.0.0.1:18830\"}";

// What pages name besides: mote 7 of wsn-1, and devices that wait for a decision.
const std::string kOtherMotes =
    "networks.wsn-1={type: wsn, source: \"network@127.0.0.1:19207\", board: EM1000, sampling: read-updates, actuators: "
    "assumed}";
const std::string kWaiting = "networks.dummy-new={type: dummy, simulate: {guest: {}, stranger: {}}}";
const std::string kAsk = "discovery={rules: [{network: dummy-new, new-devices: ask}]}";

/// One secure tunnel of the interface 1.1.0.
support::KeyringElement hall_keyring() {
  auto root = support::keyring_root("Hall");
  root.add(support::KeyringElement{"Interface"}
               .text("Type", "Tunneling")
               .text("IndividualAddress", "1.1.200")
               .text("Host", "1.1.0")
               .text("UserID", "3")
               .password("Password", "tunnel three"));
  return root;
}

}  // namespace

DemoIsland::DemoIsland() : folder_(fs::temp_directory_path() / ("rubicon_examples_" + std::to_string(::getpid()))) {
  if (!network_.entered()) return;
  write_files();
  const auto start = [this](std::vector<std::string> words) {
    running_.push_back(std::make_unique<support::Process>(std::move(words)));
  };
  start({kPrograms + "/salad-simulator", kExamples + "/home.yaml", "--bind", "127.0.0.1", "--script",
         kExamples + "/salad.script", "--log-level", "error"});
  const auto motes = [&](const char* count, const char* port, std::vector<std::string> more) {
    std::vector<std::string> words{kPrograms + "/motes-simulator",
                                   "--motes",
                                   count,
                                   "--board",
                                   "EM1000",
                                   "--obey",
                                   "--updates",
                                   "--wait",
                                   "--port",
                                   port};
    words.insert(words.end(), more.begin(), more.end());
    start(std::move(words));
  };
  motes("6", "19202", {"--script", kExamples + "/motes.script"});
  motes("8", "19207", {});  // without the script, in which mote 7 is off for a minute
  std::vector<std::string> island{
      kPrograms + "/rubicon-proxy",
      "run",
      kExamples + "/home.yaml",
      "--set",
      kMotes,
      "--set",
      kOtherMotes,
      "--set",
      kWaiting,
      "--set",
      kAsk,
      "--set",
      "state.file=" + (folder_ / "demo.state").string(),
      "--set",
      "web={listen: \"127.0.0.1:8642\"}",
      "--set",
      "history={file: " + (folder_ / "island.history").string() + "}",
      "--set",
      "recorders={all: {file: " + (folder_ / "all.rec").string() + ", patterns: [\"proxy.*.*.sensor.*.value\"]}}",
      "--shell",
      "--log-level",
      "error"};
  start({kPrograms + "/knx-simulator", kExamples + "/knx.script", "--listen", "13671", "--log-level", "error"});
  island.insert(island.end(), {"--set", kKnx});
  start_broker();
  start({kPrograms + "/zigbee-simulator", kExamples + "/zigbee.script", "--broker", "127.0.0.1:18830", "--log-level",
         "error"});
  island.insert(island.end(), {"--set", kZigbee});
  start(std::move(island));
  auto& shell = *running_.back();
  // As the live table of ./run, it wants all sensors. Its motes join one after the other.
  shell.write("subscribe proxy.*.*.sensor.*.value min=1s\n");
  std::vector<std::string> wanted{"proxy.wsn-flat.1.status", "proxy.wsn-1.7.status", "proxy.dummy-rooms.living.status"};
  if (broker_) wanted.push_back("proxy.zigbee.00124b0010000000.status");
  for (const auto& key : wanted) {
    for (int i = 0; i < 1000; ++i) {
      shell.write("get " + key + "\n");
      const auto line = shell.line_with("\"ok\"");
      if (line && line->find("\\\"reachable\\\"") != line->npos) break;
      ::usleep(100'000);
    }
  }
}

/// Without mosquitto the ZigBee devices stay away, as in ./run.
void DemoIsland::start_broker() {
  if (!support::Mosquitto::missing().empty()) return;
  support::MosquittoOptions options;
  options.port = 18830;
  broker_ = std::make_unique<support::Mosquitto>(options);
}

DemoIsland::~DemoIsland() {
  for (const auto& one : running_) one->signal(SIGTERM);
  for (const auto& one : running_) one->exit_code();  // a script ends what it started only if it is not killed
  running_.clear();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void DemoIsland::write_files() const {
  fs::remove_all(folder_);
  fs::create_directories(folder_ / ".zfunc");
  fs::copy(kExamples, folder_ / "examples", fs::copy_options::recursive);  // examples write into it
  const auto write = [this](const char* name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  };
  const std::string home =
      "island: {id: 7, name: home}\nstate: {file: home.state}\nnetworks:\n  dummy-1: {type: dummy, simulate: {hall: "
      "{}}}\n";
  write("home.yaml", home);
  write("home.state.good.yaml", home);  // a start of it, which another part of the examples has, leaves this
  write("island.yaml", "island: {id: 8}\nnetworks:\n  dummy-1: {type: dummy, simulate: {hall: {}}}\n");
  write("map.png", "not a picture");
  support::Process({kPrograms + "/rubicon", "history", (folder_ / "demo.history").string(), "import",
                    kExamples + "/recordings/demo_hour.rec"})
      .exit_code();
  const std::string addresses =
      "\"Group name\",\"Address\",\"Central\",\"Unfiltered\",\"Description\",\"DatapointType\",\"Security\"\n"
      "\"Hall lamp\",\"1/0/1\",\"\",\"\",\"\",\"DPST-1-1\",\"Auto\"\n";
  for (const auto* name : {"flat.csv", "new.csv", "newer.csv"}) write(name, addresses);
  write("flat.knxproj", support::small_house(20).file());
  auto protected_house = support::small_house(23);
  protected_house.password = "flatpass";
  write("hall.knxproj", protected_house.file());
  write("hall.knxkeys", support::write_keyring(hall_keyring(), "flatpass"));
  for (const auto* name : {"hall.password", "project.password"}) {
    write(name, "flatpass\n");
    fs::permissions(folder_ / name, fs::perms::owner_read | fs::perms::owner_write);
  }
}

std::vector<std::string> DemoIsland::command(const std::string& line, int seconds) const {
  // An island on a busy machine answers late. On PEIS there is no component that could answer.
  const auto patience = line.find("--engine peis") == line.npos ? "RUBICON_PATIENCE=30s" : "RUBICON_PATIENCE=3s";
  return {"env",
          "PATH=" + kPrograms + ":" + ::getenv("PATH"),
          "HOME=" + folder_.string(),
          patience,
          "timeout",
          "--preserve-status",
          "--signal=INT",
          "--kill-after=60",
          std::to_string(seconds),
          "bash",
          "-c",
          "set -o pipefail; cd " + folder_.string() + "; " + line};
}

}  // namespace rubicon::examples
