#include <unistd.h>

#include "frame/process_figures.h"
#include "web/rig.h"
#include "web/watched_values.h"

namespace rubicon::bench::web {

namespace {

using namespace std::chrono_literals;

constexpr auto kSettling = 1s;

/// Share of a core, in percent, of what a process did while `work` ran.
template <class Work>
double share(pid_t pid, Work work) {
  const auto began = Clock::now();
  const auto before = processor_seconds(pid);
  work();
  return rounded((processor_seconds(pid) - before) / seconds_since(began) * 100, 2);
}

void pause(Clock::duration span) {
  ::usleep(static_cast<useconds_t>(std::chrono::duration_cast<std::chrono::microseconds>(span).count()));
}

/// One client at one pace. `source` makes the updates, `server` is the process that sends them.
template <class Client>
Json watch(const Plan& plan, RoleProcess& source, pid_t server, int rate, int port) {
  source.set_rate(rate);
  pause(kSettling);
  const auto alone = share(server, [&] { pause(plan.watched); });
  Client client(port, plan.devices);
  client.watch(kSettling);
  const auto before = source.made();
  client.seen.restart();
  const auto with_client = share(server, [&] { client.watch(plan.watched); });
  const auto& seen = client.seen;
  const auto seconds = static_cast<double>(plan.watched.count());
  Json figures{
      {"cpu_percent", with_client},
      {"without_client_cpu_percent", alone},
      {"updates_per_second", rounded(static_cast<double>(seen.updates) / seconds, 0)},
      {"messages_per_second", rounded(static_cast<double>(seen.messages) / seconds, 1)},
      {"bytes_per_update", rounded(static_cast<double>(seen.bytes) / static_cast<double>(seen.updates), 1)},
      {"age_ms", {{"p50", rounded(median(seen.ages_ms), 1)}, {"p99", rounded(percentile(seen.ages_ms, 0.99), 1)}}}};
  const auto made = source.set_rate(0);
  client.settle();
  figures["wrong_final_values"] = client.seen.wrong(made, before);
  return figures;
}

}  // namespace

/// One client that follows all values, at two paces, and the same at mosquitto.
void measure_updates(const Plan& plan, Json& out) {
  const Rig rig(out, "updates");
  if (!rig) return;
  auto& figures = out["updates"];
  auto island = rig.island(plan);
  for (const int rate : {1'000, 10'000})
    figures[std::to_string(rate)] = watch<PageClient>(plan, island, island.pid(), rate, island.port());
  const auto peer = rig.peer(plan);
  if (!peer) return;
  for (const int rate : {1'000, 10'000})
    figures["mosquitto"][std::to_string(rate)] =
        watch<BrokerClient>(plan, peer->publisher, peer->broker->process().pid(), rate, Peer::kSocketPort);
}

}  // namespace rubicon::bench::web
