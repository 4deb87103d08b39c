#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <set>

#include "motes/rig.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;
using motes_simulator::Event;

constexpr int kSinks = 2;
constexpr int kRestartMotes = 20;
constexpr auto kRestartStep = 20ms;
constexpr auto kRestartPatience = 60s;

/// Removed with its content.
class Folder {
 public:
  Folder() {
    if (::mkdtemp(path_.data()) == nullptr) must(fail(ErrorCode::kIo, path_));
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file() const { return path_ + "/island.state"; }

 private:
  std::string path_ = std::filesystem::temp_directory_path() / "rubicon-bench-XXXXXX";
};

struct Outcome {
  std::uint64_t motes = 0, back = 0, sampled_again = 0;
  std::vector<double> seconds;  ///< of each mote, from the island's start
  std::vector<double> milliseconds;
  std::uint64_t reboots = 0;
};

/// Motes, half of which report each second, and an island that is ended and started again.
class Restarts {
 public:
  explicit Restarts(bool remembers)
      : remembers_(remembers),
        rig_(kSinks, kRestartMotes, {}, [this](const Event& event) { boots_ += event.what == "boot"; }) {
    for (std::uint16_t sink = 1; sink <= kSinks; ++sink) {
      for (int i = 0; i < kRestartMotes / 2; ++i) {
        const auto key = fmt::format("proxy.wsn-{}.{}.sensor.light-1.value", sink, first_of(sink) + i);
        demand_.push_back(component_->subscribe({kIslandOwner, key}, {}, [](const tuples::Event&) {}));
      }
    }
  }

  Outcome run(int restarts) {
    Outcome outcome;
    start();
    rig_.time.run_for(30s);
    const auto before = boots_;
    for (int i = 0; i < restarts; ++i) {
      rig_.time.run_for(std::chrono::milliseconds(1000 + rng_() % 10'000));
      island_.reset();
      rig_.time.run_for(std::chrono::milliseconds(200 + rng_() % 3000));
      const auto began = Clock::now();
      start();
      rig_.time.run_ready();
      outcome.milliseconds.push_back(milliseconds(Clock::now() - began));
      await(outcome);
    }
    outcome.reboots = boots_ - before;
    return outcome;
  }

 private:
  static std::uint16_t first_of(int sink) { return static_cast<std::uint16_t>(2 + (sink - 1) * kRestartMotes); }

  void start() {
    auto state = remembers_ ? must(state::StateStore::open(folder_.file(), IslandId{kIsland})) : nullptr;
    island_ = start_island(island_of(ports_of(kSinks), "silence: 60s, share: no"), rig_.time, rig_.transports,
                           rig_.ecology, std::move(state));
  }

  void await(Outcome& outcome) {
    std::set<std::uint16_t> missing;
    for (std::uint16_t mote = first_of(1); mote < first_of(kSinks + 1); ++mote) missing.insert(mote);
    outcome.motes += missing.size();
    const auto from = rig_.time.now();
    while (!missing.empty() && rig_.time.now() < from + kRestartPatience) {
      rig_.time.run_for(kRestartStep);
      std::erase_if(missing, [&](std::uint16_t mote) {
        const auto sink = static_cast<std::uint16_t>(1 + (mote - 2) / kRestartMotes);
        if (!reachable(*island_, sink, mote)) return false;
        outcome.seconds.push_back(std::chrono::duration<double>(rig_.time.now() - from).count());
        return true;
      });
    }
    outcome.back += static_cast<std::uint64_t>(kSinks * kRestartMotes) - missing.size();
  }

  bool remembers_;
  Folder folder_;
  std::uint64_t boots_ = 0;
  VirtualRig rig_;
  Component component_{rig_.ecology, rig_.time, 70001};
  std::vector<Handle> demand_;
  std::mt19937 rng_{7};
  std::unique_ptr<island::Island> island_;
};

}  // namespace

void measure_restarts(const Plan& plan, Json& out) {
  const auto ours = Restarts(true).run(plan.restarts);
  const auto forgetful = Restarts(false).run(std::min(plan.restarts, 5));
  const auto share = [](const Outcome& one) {
    return rounded(static_cast<double>(one.back) / static_cast<double>(one.motes), 4);
  };
  out["restarts"] = {{"restarts", plan.restarts},
                     {"motes", kSinks * kRestartMotes},
                     {"mote_reboots", ours.reboots},
                     {"back_share", share(ours)},
                     {"back_s",
                      {{"median", rounded(median(ours.seconds), 2)},
                       {"p99", rounded(percentile(ours.seconds, 0.99), 2)},
                       {"max", rounded(percentile(ours.seconds, 1), 2)}}},
                     {"start_ms", rounded(median(ours.milliseconds), 1)},
                     {"peer_without_state_back_share", share(forgetful)}};
}

}  // namespace rubicon::bench::motes
