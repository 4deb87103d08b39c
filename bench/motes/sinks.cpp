#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <set>
#include <stdexcept>

#include "frame/daemon.h"
#include "frame/process_figures.h"
#include "motes/framing.h"
#include "motes/mote_records.h"
#include "motes/rig.h"
#include "support/private_network.h"
#include "support/process.h"
#include "transport/asio_scheduler.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;
using support::Process;

constexpr int kSinkMotes = 20;
constexpr std::uint32_t kDomain = 198;
/// 12 sensors; the other one has two.
const std::string kMaxBoard = "EM1000", kMinBoard = "SE1000";

/// A client in this process, which sees the daemon over DDS.
class Watcher {
 public:
  Watcher() {
    component_ = std::make_unique<Component>(*ecology_, loop_.scheduler(), 70001);
    status_ =
        (*component_)->subscribe({kIslandOwner, "proxy.*.*.status"}, {{}, {}, 0, true}, [this](const auto& event) {
          const bool there = event.tuple.value.find("\"reachable\"") != std::string_view::npos;
          if (there) reachable_.emplace(event.tuple.key);
        });
  }
  void run(Duration span) {
    const auto end = loop_.scheduler().after(span, [this] { loop_.stop(); });
    loop_.run();
  }
  /// Runs until this many are reachable, or no more joined for some seconds: a sink loses a join now and then
  /// (wsn.md 9.2).
  std::size_t await(std::size_t motes) {
    std::size_t before = 0;
    for (int idle = 0; idle < 10 && reachable_.size() < motes; idle = reachable_.size() > before ? 0 : idle + 1) {
      before = reachable_.size();
      run(1s);
    }
    return reachable_.size();
  }
  void demand(Duration period) {
    light_ = (*component_)
                 ->subscribe({kIslandOwner, "proxy.*.*.sensor.light-1.value"}, {period, {}, 0, false},
                             [this](const tuples::Event&) { ++readings_; });
  }
  Json load(const Daemon& daemon, Duration span) {
    const auto before = daemon.processor();
    const auto began = Clock::now();
    readings_ = 0;
    run(span);
    const auto took = seconds_since(began);
    return {{"cpu_percent", rounded((daemon.processor() - before) / took * 100, 2)},
            {"resident_mb", daemon.resident_mb()},
            {"readings_per_second", rounded(static_cast<double>(readings_) / took, 1)}};
  }

 private:
  transport::Loop loop_;
  std::unique_ptr<tuples::dds::DdsEcology> ecology_ = join_on_loopback(kDomain, loop_.scheduler());
  std::unique_ptr<Component> component_;
  std::set<std::string, std::less<>> reachable_;
  std::uint64_t readings_ = 0;
  Handle status_, light_;
};

/// The motes, in a process of their own.
std::unique_ptr<Process> simulator(const Plan& plan, const std::string& board) {
  auto process = std::make_unique<Process>(std::vector<std::string>{
      RUBICON_BINARY_DIR "/bin/motes-simulator", "--sinks", std::to_string(plan.sinks), "--motes",
      std::to_string(kSinkMotes), "--port", std::to_string(kFirstPort), "--board", board, "--wait"});
  for (int i = 0; i < plan.sinks; ++i) {
    if (!process->line()) throw std::runtime_error("motes-simulator: " + process->errors());
  }
  return process;
}

/// Only reads and checks as many frames a second from as many connections: processor time in percent.
double bare_reader(const Plan& plan, int frames_per_second) {
  std::vector<pollfd> ends;
  std::vector<int> others;
  for (int i = 0; i < plan.sinks; ++i) {
    std::array<int, 2> pair{};
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()) != 0) throw std::runtime_error("socketpair");
    ends.push_back({pair[0], POLLIN, 0});
    others.push_back(pair[1]);
  }
  const auto frame = rubicon::motes::hdlc_packet(Bytes(122, 0x11));
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
  std::vector<rubicon::motes::HdlcReader> readers(ends.size());
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
  const auto percent = (used() - before) / seconds_since(began) * 100;
  for (const auto& end : ends) ::close(end.fd);
  ::waitpid(writer, nullptr, 0);
  return rounded(percent, 2);
}

std::string configuration(const Plan& plan) {
  return island_of(ports_of(plan.sinks), fmt::format("silence: {}s, share: no", plan.silence.count()));
}

void measure(const Plan& plan, const std::string& board, Json& figures) {
  const auto motes = simulator(plan, board);
  const Daemon daemon(configuration(plan), kDomain);
  Watcher watcher;
  const auto wanted = static_cast<std::size_t>(plan.sinks * kSinkMotes);
  figures["motes"] = wanted;
  figures["listed"] = watcher.await(wanted);
  watcher.run(plan.silence / 2);  // from now on each mote is probed each half of the silence
  figures["idle_probed"] = watcher.load(daemon, plan.sampled);
  for (const auto& [name, period] : {std::pair{"each_10_s", 10s}, std::pair{"each_1_s", 1s}}) {
    if (board != kMaxBoard || plan.sampled < period) continue;
    watcher.demand(period);
    watcher.run(5s + 2 * period);  // a mote reports what it read a period before (wsn.md 9.4)
    figures[name] = watcher.load(daemon, plan.sampled);
    figures[name]["floor_cpu_percent"] =
        bare_reader(plan, static_cast<int>(static_cast<std::int64_t>(wanted) / period.count()));
  }
  figures["simulator_cpu_seconds"] = rounded(processor_seconds(motes->pid()), 1);
}

}  // namespace

void measure_sinks(const Plan& plan, Json& out) {
  const support::PrivateNetwork network;  // without one, its ports and DDS domain may meet others'
  auto& figures = out["sinks"];
  figures = {{"sinks", plan.sinks}, {"private_network", network.entered()}};
  for (const auto& board : {kMaxBoard, kMinBoard}) measure(plan, board, figures[board]);
}

}  // namespace rubicon::bench::motes
