#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <thread>

#include "support/conversation.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr long kGrowth = 4096;  ///< kilobytes that caches, logs and the allocator may take

/// RUBICON_CHAOS_SECONDS, 15 if not given.
std::chrono::seconds patience() {
  const auto* wanted = std::getenv("RUBICON_CHAOS_SECONDS");
  return std::chrono::seconds(wanted ? std::atoi(wanted) : 15);
}

/// The real programs, on real sockets and real time: SALAD is killed, stopped, delayed, floods and talks rubbish; the
/// island is told to read its file again and again.
class RealChaos : public testing::Test {
 protected:
  RealChaos() {
    directory_ = std::filesystem::path(testing::TempDir()) / ("rubicon_real_chaos" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
    configure(0);
  }
  ~RealChaos() override { std::filesystem::remove_all(directory_); }

  /// The flat of the example, rooms beside it, a memory; `turn` names one of the rooms.
  void configure(int turn) {
    std::ifstream flat(kFlat);
    std::string text((std::istreambuf_iterator<char>(flat)), std::istreambuf_iterator<char>());
    std::ofstream(directory_ / "flat.yaml", std::ios::binary)
        << text << "\n  dummy-1:\n    type: dummy\n    simulate:\n      hall: {name: Hall " << turn
        << ", sensors: {temperature-1: {wave: sine, low: 10, high: 30, period: 1s}}, properties: {rate: 20}}\n"
        << "state: {file: flat.state, save-every: 500ms}\ntuples: {engine: memory}\n";
  }
  std::string file() const { return (directory_ / "flat.yaml").string(); }

  void start_salad(std::vector<std::string> more) {
    std::vector<std::string> arguments{kSimulator, kFlat, "--log-level", "off"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    salad_.reset();
    salad_.emplace(std::move(arguments));
    ASSERT_TRUE(salad_->line_with("listening"));
  }
  static testing::AssertionResult becomes(Process& shell, const std::string& key, const json& wanted,
                                          const std::string& part = "") {
    json line;
    for (const auto end = Clock::now() + 60s; Clock::now() < end; std::this_thread::sleep_for(20ms)) {
      line = ask(shell, "get " + key);
      const auto value = json::parse(line.value("value", ""), nullptr, false);
      if (value == wanted || (value.is_object() && value.value(json::json_pointer(part), json()) == wanted))
        return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << key << " should be " << wanted << ", the island says " << line;
  }
  void misfortune(Process& shell) {
    switch (dice_() % 6) {
      case 0: start_salad({"--period", "20ms", "--misbehave", "all"}); break;
      case 1: start_salad({"--period", "1ms"}); break;
      case 2:
        if (salad_) salad_->signal(SIGSTOP);
        break;
      case 3:
        if (salad_) salad_->signal(SIGCONT);
        break;
      case 4: salad_.reset(); break;
      case 5:
        configure(static_cast<int>(dice_() % 5));
        shell.signal(SIGHUP);
        break;
    }
    for (int i = 0; i < 20; ++i) ask(shell, "set proxy.salad.28.actuator.status-tv_state.command " + std::to_string(i));
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + dice_() % 300));
  }

  std::filesystem::path directory_;
  std::optional<Process> salad_;
  std::mt19937 dice_{1};
};

TEST_F(RealChaos, AfterwardsEveryValueIsRightAndNothingGrew) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  Process shell(
      {kDaemon, "run", file(), "--shell", "--log-level", "off", "--set", "networks.salad.start-again-after=200ms"});
  ASSERT_TRUE(ask(shell, "subscribe proxy.dummy-1.hall.sensor.*.value min=100ms").value("ok", false));
  for (int i = 0; i < 10; ++i) misfortune(shell);
  const auto descriptors = shell.open_descriptors();
  const auto memory = shell.resident_kilobytes();
  const auto end = Clock::now() + patience();
  while (Clock::now() < end) misfortune(shell);

  start_salad({"--period", "50ms"});
  EXPECT_TRUE(becomes(shell, "proxy.salad.28.actuator.status-tv_state.value", 0));
  ASSERT_TRUE(ask(shell, "set proxy.salad.28.actuator.status-tv_state.command 42").value("ok", false));
  EXPECT_TRUE(becomes(shell, "proxy.salad.28.actuator.status-tv_state.value", 42));
  EXPECT_TRUE(becomes(shell, "proxy.salad.28.actuator.status-tv_state.status", "confirmed", "/command/state"));
  for (int id = 1; id <= 50; ++id) {
    if (id == 29) continue;
    EXPECT_TRUE(becomes(shell, "proxy.salad." + std::to_string(id) + ".status", "reachable", "/status")) << id;
  }
  configure(7);
  shell.signal(SIGHUP);
  EXPECT_TRUE(becomes(shell, "proxy.dummy-1.hall.description", "Hall 7", "/name"));
  EXPECT_TRUE(becomes(shell, "proxy.dummy-1.hall.sensor.temperature-1.status", "good", "/quality"));
  for (const auto last = Clock::now() + 60s; Clock::now() < last && shell.open_descriptors() > descriptors;)
    std::this_thread::sleep_for(50ms);  // a save of the state has a file open
  EXPECT_LE(shell.open_descriptors(), descriptors);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LE(shell.resident_kilobytes(), memory + kGrowth);
#endif
  std::printf("descriptors %ld -> %ld, resident %ld kB -> %ld kB in %lld s\n", descriptors, shell.open_descriptors(),
              memory, shell.resident_kilobytes(), static_cast<long long>(patience().count()));
  shell.write("quit\n");
  EXPECT_EQ(shell.exit_code(), 0);
}

}  // namespace
}  // namespace rubicon::daemon
