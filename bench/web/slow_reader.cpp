#include <unistd.h>

#include "web/rig.h"
#include "web/watched_values.h"

namespace rubicon::bench::web {

namespace {

using namespace std::chrono_literals;

constexpr int kRate = 10'000;
constexpr double kFresh = 250;   ///< ms: five intervals of the subscription
constexpr double kMaxTime = 30;  ///< s

/// A client that takes nothing for a while, and then reads again.
template <class Client, class Resident>
Json fall_silent(const Plan& plan, RoleProcess& source, int port, Resident resident) {
  Client client(port, plan.devices);
  const auto made_before = source.made();
  source.set_rate(kRate);
  client.watch(2s);
  const auto before = resident();
  ::usleep(static_cast<useconds_t>(std::chrono::microseconds(plan.silence).count()));
  const auto grown = resident() - before;
  client.seen.restart();
  const auto again = Clock::now();
  auto& ages = client.seen.ages_ms;
  while (seconds_since(again) < kMaxTime && (ages.empty() || ages.back() > kFresh)) client.watch(1ms);
  const auto fresh = milliseconds(Clock::now() - again);
  const auto behind = client.seen.bytes;
  const auto made = source.set_rate(0);
  client.settle();
  return {{"grown_mb", rounded(grown, 1)},
          {"fresh_after_ms", rounded(fresh, 0)},
          {"kb_until_fresh", rounded(static_cast<double>(behind) / 1e3, 0)},
          {"wrong_final_values", client.seen.wrong(made, made_before)}};
}

}  // namespace

/// A client that reads nothing while all values change, and the same at mosquitto.
void measure_slow_reader(const Plan& plan, Json& out) {
  const Rig rig(out, "slow_reader");
  if (!rig) return;
  auto& figures = out["slow_reader"];
  auto island = rig.island(plan);
  figures["rubicon"] = fall_silent<PageClient>(plan, island, island.port(), [&island] { return island.resident_mb(); });
  const auto peer = rig.peer(plan);
  if (!peer) return;
  figures["mosquitto"] = fall_silent<BrokerClient>(plan, peer->publisher, Peer::kSocketPort, [&peer] {
    return static_cast<double>(peer->broker->process().resident_kilobytes()) * 1.024 / 1000;
  });
}

}  // namespace rubicon::bench::web
