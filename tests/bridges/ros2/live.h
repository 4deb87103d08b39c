#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "base/virtual_scheduler.h"
#include "bridges/bridge.h"
#include "bridges/town_island.h"
#include "support/collecting_log.h"
#include "support/config_text.h"
#include "support/memory/memory_transports.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/rights.h"
#include "transport/asio_scheduler.h"

namespace rubicon::bridges::ros2 {

using namespace std::chrono_literals;

/// A program of the other side: what it prints is read as it comes.
class Robot {
 public:
  /// Does what rmw does: tests/bridges/ros2/robot.
  explicit Robot(const std::string& distribution = "humble", unsigned domain = 0, unsigned lease_ms = 1000)
      : Robot(std::vector<std::string>{RUBICON_BINARY_DIR "/bin/ros-robot", std::to_string(domain), distribution,
                                       std::to_string(lease_ms)}) {}
  explicit Robot(std::vector<std::string> program) : process_(std::move(program)), reader_([this] { read(); }) {}
  ~Robot() {
    kill();
    reader_.join();
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void say(const std::string& command) { process_.write(command + "\n"); }
  void kill() { process_.signal(SIGKILL); }
  /// Lines that contain the text.
  std::vector<std::string> lines(const std::string& part) const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> found;
    for (const auto& line : lines_) {
      if (line.find(part) != line.npos) found.push_back(line);
    }
    return found;
  }
  bool saw(const std::string& part) const { return !lines(part).empty(); }

 private:
  void read() {
    for (auto line = process_.line(); line; line = process_.line()) {
      const std::lock_guard lock(mutex_);
      lines_.push_back(std::move(*line));
    }
  }

  support::Process process_;
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
  std::thread reader_;
};

/// The time of a loop, which a test may advance: what is due by then runs at once. Robots do not notice.
class LeapingTime final : public Scheduler {
 public:
  explicit LeapingTime(Scheduler& real) : real_(real) {}
  void leap(Duration span) {
    leapt_ += span;
    arm();
  }

  SteadyTime now() const override { return real_.now() + leapt_; }
  WallTime wall_now() const override {
    return real_.wall_now() + std::chrono::duration_cast<WallTime::duration>(leapt_);
  }
  void post(std::function<void()> call) override { real_.post(std::move(call)); }
  Timer at(SteadyTime when, std::function<void()> call) override {
    auto timer = timers_.add(when, std::move(call));
    arm();
    return timer;
  }
  bool on_loop_thread() const override { return real_.on_loop_thread(); }

 private:
  void arm() {
    if (const auto next = timers_.next()) wake_ = real_.at(std::max(*next - leapt_, real_.now()), [this] { run(); });
  }
  void run() {
    while (const auto call = timers_.take_due(now())) call();
    arm();
  }

  Scheduler& real_;
  Duration leapt_{0};
  base::TimerHeap timers_;
  Timer wake_;
};

/// An island of tuples and a bridge, on a network of this process alone.
class Live : public ::testing::Test {
 protected:
  void SetUp() override {
    static const support::PrivateNetwork network;
    if (!network.entered()) GTEST_SKIP() << network.reason();
    judge->record_by(audit);
    demand_ = island.space.watch_demand(Pattern::parse("proxy.**").value(), [this](const tuples::Demand& demand) {
      if (demand.wanted)
        wanted.insert(std::string(demand.key));
      else
        wanted.erase(std::string(demand.key));
    });
  }

  /// `options` beside the type.
  void bridge(const std::string& options = "{}") {
    options_ = support::config_of(nlohmann::ordered_json(json::parse(options)));
    base::ConfigErrors errors;
    ConfigReader reader(options_, "bridges.robots", errors);
    link_ = ecology.join(OwnerId(70000)).value();
    space_ = std::make_unique<TupleSpace>(OwnerId(70000), loop.scheduler(), *link_);
    const BridgeHost host{
        "robots", time, *space_, files, log, alone ? std::nullopt : std::optional(OwnerId(6541)), prefix, judge.get()};
    made = find_bridge_type("ros2")->make(reader, "", &host);
    ASSERT_TRUE(made) << errors.text();
    made->start();
  }
  void end_bridge() {
    made.reset();
    space_.reset();
    link_.reset();
  }
  TupleSpace& bridge_space() { return *space_; }

  /// Runs the loop until it is so; false: not within half a minute.
  bool until(const std::function<bool()>& done) {
    for (int i = 0; i < 6000 && !done(); ++i) run(5ms);
    return done();
  }
  void run(Duration span) {
    const auto end = loop.scheduler().after(span, [this] { loop.stop(); });
    loop.run();
  }
  /// The robot has a line that contains this.
  bool sees(const Robot& robot, const std::string& part) {
    return until([&] { return robot.saw(part); });
  }
  std::uint64_t counter(const std::string& name) const { return made->status().counters.at(name); }
  std::string tuple(const std::string& key) {
    const auto found = space_->get(OwnerId(70000), key);
    return found ? std::string(found->value) : "(none)";
  }

  transport::Loop loop;
  LeapingTime time{loop.scheduler()};  ///< of the bridge
  transport::MemoryTransports files;
  support::CollectingLog log;
  tuples::MemoryEcology ecology{loop.scheduler()};
  TownIsland island{ecology, loop.scheduler(), OwnerId(6541), "home"};
  std::shared_ptr<support::CollectingAudit> audit = std::make_shared<support::CollectingAudit>();
  std::shared_ptr<rights::RightsJudge> judge = std::make_shared<rights::RightsJudge>(rights::Rights(
      {support::rule("everybody", {support::Right::kRead, support::Right::kDemand, support::Right::kSet})}));
  std::set<std::string> wanted;  ///< keys in demand
  bool alone = false;            ///< not of an island
  std::string prefix = "proxy";  ///< of what the bridge imports

 private:
  Handle demand_;
  ConfigNode options_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;

 protected:
  std::unique_ptr<Bridge> made;
};

}  // namespace rubicon::bridges::ros2
