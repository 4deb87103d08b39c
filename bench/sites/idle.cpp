#include <chrono>
#include <thread>
#include <utility>

#include "components/rounds.h"
#include "frame/connection_figures.h"
#include "sites/broker.h"
#include "sites/measurements.h"
#include "sites/site.h"

namespace rubicon::bench::sites {

/// Nobody has anything to do with it.
Json idle_island(const Meeting& meeting, const Json& options) {
  Node node(OwnerId(options.at("id").get<std::uint32_t>()), meeting);
  const Site site(node.space(), options.at("devices"));
  const auto seconds = std::chrono::duration<double>(options.at("seconds").get<double>());
  node.rest(std::chrono::seconds(options.at("settle_s").get<int>()));
  const auto before = passed_on_connections();
  const auto used = own_processor_seconds();
  node.rest(std::chrono::duration_cast<Duration>(seconds));
  const auto after = passed_on_connections();
  return {{"heard_per_second", rounded((after.received - before.received) / seconds.count(), 1)},
          {"said_per_second", rounded((after.sent - before.sent) / seconds.count(), 1)},
          {"processor_percent", rounded((own_processor_seconds() - used) / seconds.count() * 100, 3)}};
}

void measure_idle(const Plan& plan, Report& report) {
  Json bytes, all;
  double most = 0;
  for (const auto& [what, secure] : {std::pair("plain", false), std::pair("tls", true)}) {
    const Broker broker(plan, report, "idle", secure);
    if (!broker) return;
    auto idle = start_role(
        "idle-island", broker.new_meeting(plan),
        {{"id", 7}, {"devices", 100}, {"settle_s", plan.is_quick ? 1 : 5}, {"seconds", plan.is_quick ? 1 : 60}});
    all[what] = result_of(idle);
    const auto both = all[what].at("heard_per_second").get<double>() + all[what].at("said_per_second").get<double>();
    bytes[what] = rounded(both, 1);
    most = std::max(most, both);
  }
  report.figure("idle_island_bytes_per_second", bytes);
  report.target("idle_island_bytes_per_second", "at most 50", most <= 50);
  report.detail("idle_island_bytes_per_second",
                {{"method",
                  "IP packets in both directions of the connection of an island with 100 devices that is alone at the "
                  "broker, as the kernel counts them, headers included"},
                 {"rounds", all}});
}

/// What one sensor costs that somebody watches.
void measure_reading(const Plan& plan, Report& report) {
  const double rate = 10, seconds = plan.is_quick ? 1 : 20;
  Json figures;
  for (const auto& [what, secure] : {std::pair("plain", false), std::pair("tls", true)}) {
    const Broker broker(plan, report, "reading", secure);
    if (!broker) return;
    const auto meeting = broker.new_meeting(plan);
    auto owner = start_role("paced-writer", meeting, {{"keys", 1}, {"per_second", rate}, {"seconds", seconds}});
    auto watcher = start_role("follower", meeting, {{"keys", 1}, {"sets", rate * seconds}});
    std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(seconds * 250)));
    const auto before = broker.processor();
    std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(seconds * 500)));
    const auto used = broker.processor() - before;
    const auto watched = result_of(watcher), owned = result_of(owner);
    const auto of_one = [&](const Json& side, const char* name) {
      return rounded(side.at(name).get<double>() / (rate * seconds), 0);
    };
    figures[what] = {{"owner_sends_bytes", of_one(owned, "sent_bytes")},
                     {"owner_hears_bytes", of_one(owned, "received_bytes")},
                     {"watcher_hears_bytes", of_one(watched, "received_bytes")},
                     {"watcher_sends_bytes", of_one(watched, "sent_bytes")},
                     {"broker_us", rounded(used / (rate * seconds / 2) * 1e6, 0)}};
  }
  report.figure("a_watched_reading", figures);
  report.detail("a_watched_reading",
                {{"method",
                  "one value of 64 bytes, ten times a second, watched by one other site: IP packets with headers and "
                  "acknowledgements at both connections, and processor time of the broker, for each value"}});
}

}  // namespace rubicon::bench::sites
