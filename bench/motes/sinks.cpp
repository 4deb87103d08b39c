#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "daemon/private_network.h"
#include "daemon/process.h"
#include "motes/hdlc.h"
#include "motes/mote_records.h"
#include "motes/rig.h"

namespace rubicon::bench::wsn {

namespace {

using namespace std::chrono_literals;
using daemon::Process;

constexpr int kMotes = 20;

/// Processor time of a process so far, all its threads.
double processor_seconds(pid_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::istringstream rest(text.substr(std::min(text.size(), text.rfind(')') + 1)));
  std::string word;
  for (int field = 3; field < 14; ++field) rest >> word;
  double user = 0, system = 0;
  rest >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

/// The program rubicon-proxy with a network for each sink, and its shell.
class Daemon {
 public:
  Daemon(const std::string& folder, const Plan& plan) : process_(arguments(folder, plan)) {}

  /// Counts what it prints besides.
  Json ask(const std::string& command) {
    process_.write(command + "\n");
    while (auto line = process_.line()) {
      if (line->starts_with("{\"ok\"")) return Json::parse(*line, nullptr, false);
      ++printed_;
    }
    throw std::runtime_error("the daemon does not answer: " + process_.errors());
  }
  /// Takes what it prints: readings.
  std::uint64_t drain(Clock::duration span) {
    const auto before = printed_;
    for (const auto end = Clock::now() + span; Clock::now() < end; ask("get proxy.networks")) ::usleep(100'000);
    return printed_ - before;
  }
  Json load(Clock::duration span) {
    const auto before = processor_seconds(process_.pid());
    const auto began = Clock::now();
    const auto lines = drain(span);
    const auto took = std::chrono::duration<double>(Clock::now() - began).count();
    return {{"cpu_percent", rounded((processor_seconds(process_.pid()) - before) / took * 100, 2)},
            {"resident_mb", rounded(static_cast<double>(process_.resident_kilobytes()) / 1024, 1)},
            {"printed_per_second", rounded(static_cast<double>(lines) / took, 1)}};
  }
  void demand(const std::string& period) {
    ask("unsubscribe " + kLight);
    ask("subscribe " + kLight + " min=" + period);
  }

 private:
  static std::vector<std::string> arguments(const std::string& folder, const Plan& plan) {
    std::ofstream(folder + "/island.yaml")
        << island_of(ports_of(plan.sinks), fmt::format("silence: {}s, share: no", plan.silence.count()))
        << "tuples: {interfaces: [lo], domain: 198}\n";
    return {RUBICON_BINARY_DIR "/bin/rubicon-proxy", "run", folder + "/island.yaml", "--shell", "--log-level", "error"};
  }
  inline static const std::string kLight = "proxy.*.*.sensor.light-1.value";
  Process process_;
  std::uint64_t printed_ = 0;
};

/// The motes, in a process of their own.
std::unique_ptr<Process> simulator(const Plan& plan) {
  auto process = std::make_unique<Process>(
      std::vector<std::string>{RUBICON_BINARY_DIR "/bin/rubicon-motes", "--sinks", std::to_string(plan.sinks),
                               "--motes", std::to_string(kMotes), "--port", std::to_string(kFirstPort), "--wait"});
  for (int i = 0; i < plan.sinks; ++i) {
    if (!process->line()) throw std::runtime_error("rubicon-motes: " + process->errors());
  }
  return process;
}

/// Reads so many frames a second from as many connections and checks them, and nothing else: processor time in percent.
double bare_reader(const Plan& plan, int frames_per_second) {
  std::vector<pollfd> ends;
  std::vector<int> others;
  for (int i = 0; i < plan.sinks; ++i) {
    std::array<int, 2> pair{};
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()) != 0) throw std::runtime_error("socketpair");
    ends.push_back({pair[0], POLLIN, 0});
    others.push_back(pair[1]);
  }
  const auto frame = motes::hdlc_packet(Bytes(122, 0x11));
  const auto span = plan.sampled / 3;
  const pid_t writer = ::fork();
  if (writer == 0) {
    const auto began = Clock::now();
    for (std::int64_t sent = 0; Clock::now() < began + span; ++sent) {
      const auto due = began + std::chrono::nanoseconds(1'000'000'000LL * sent / frames_per_second);
      if (due > Clock::now()) ::usleep(static_cast<useconds_t>((due - Clock::now()) / 1us));
      std::ignore = ::write(others[static_cast<std::size_t>(sent) % others.size()], frame.data(), frame.size());
    }
    ::_exit(0);
  }
  for (const int other : others) ::close(other);
  std::vector<motes::HdlcReader> readers(ends.size());
  const auto used = [] {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const auto of = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
    };
    return of(usage.ru_utime) + of(usage.ru_stime);
  };
  const auto before = used();
  const auto began = Clock::now();
  std::array<std::uint8_t, 4096> buffer;
  for (bool open = true; open && ::poll(ends.data(), ends.size(), 1000) > 0;) {
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].revents == 0) continue;
      const auto count = ::read(ends[i].fd, buffer.data(), buffer.size());
      if (count <= 0) open = false;
      ByteView bytes(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
      while (readers[i].next(bytes)) continue;
    }
  }
  const auto percent = (used() - before) / std::chrono::duration<double>(Clock::now() - began).count() * 100;
  for (const auto& end : ends) ::close(end.fd);
  ::waitpid(writer, nullptr, 0);
  return rounded(percent, 2);
}

std::size_t await_motes(Daemon& daemon, std::size_t wanted) {
  std::size_t listed = 0;
  for (const auto end = Clock::now() + 60s; listed < wanted && Clock::now() < end; ::usleep(500'000))
    listed = daemon.ask("devices").value("count", std::size_t{0});
  return listed;
}

void measure(const Plan& plan, const std::string& folder, Json& figures) {
  const auto motes = simulator(plan);
  Daemon daemon(folder, plan);
  const auto wanted = static_cast<std::size_t>(plan.sinks * kMotes);
  figures["motes"] = wanted;
  figures["listed"] = await_motes(daemon, wanted);
  daemon.drain(plan.silence / 2);  // from now on each mote is asked each half of the silence
  figures["idle_probed"] = daemon.load(plan.sampled);
  for (const auto& [name, period, each] : {std::tuple{"each_10_s", "10s", 10}, std::tuple{"each_1_s", "1s", 1}}) {
    daemon.demand(period);
    // A mote reports what it read a period before (wsn.md 9.4).
    daemon.drain(std::min<std::chrono::seconds>(plan.silence, 5s + each * 2s));
    figures[name] = daemon.load(plan.sampled);
    figures[name]["floor_cpu_percent"] = bare_reader(plan, static_cast<int>(wanted) / each);
  }
  figures["simulator_cpu_seconds"] = rounded(processor_seconds(motes->pid()), 1);
}

}  // namespace

void measure_sinks(const Plan& plan, Json& out) {
  const daemon::PrivateNetwork network;  // without one, its ports and DDS domain may meet others'
  std::string folder = std::filesystem::temp_directory_path() / "rubicon-bench-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error(folder);
  auto& figures = out["sinks"];
  figures = {{"sinks", plan.sinks}, {"private_network", network.entered()}};
  measure(plan, folder, figures);
  std::filesystem::remove_all(folder);
}

}  // namespace rubicon::bench::wsn
