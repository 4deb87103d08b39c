#include <chrono>

#include "components/report.h"
#include "components/roles.h"

namespace rubicon::bench {

namespace {

constexpr std::uint32_t kFirstOfMany = 1'071'000;
constexpr base::Duration kLate = std::chrono::minutes(2);

}  // namespace

/// All components stay until the same time, so that no leaving is measured.
Json one_of_many(const Meeting& meeting, const Json& options) {
  const double begin = options.at("begin"), settled = options.at("settled_s"), idle = options.at("idle_s");
  const std::size_t others = options.at("count").get<std::size_t>() - 1;
  const auto begun = wall_seconds() - begin;
  Node node(OwnerId(kFirstOfMany + options.at("number").get<std::uint32_t>()), meeting);
  double seen = 0, used_until_seen = 0;
  int lost = 0;
  std::size_t present = 0;
  const auto watch = node.space().watch_peers([&](OwnerId, tuples::PeerEvent event) {
    lost += event == tuples::PeerEvent::kLost;
    event == tuples::PeerEvent::kUp ? ++present : --present;
    if (seen > 0 || present < others) return;
    seen = wall_seconds() - begin;
    used_until_seen = own_processor_seconds();
  });
  const auto anybody = options.value("of_any_owner", false)
                           ? node.space().subscribe({std::nullopt, "bench.met"}, {}, [](const tuples::Event&) {})
                           : Handle();
  base::Timer timer;
  const auto until = [&](double when) {
    const auto left = std::chrono::duration<double>(std::max(0.0, begin + when - wall_seconds()));
    timer = node.scheduler().after(std::chrono::duration_cast<base::Duration>(left), [&] { node.finish(); });
    node.run(kLate + std::chrono::duration_cast<base::Duration>(left));
  };
  until(settled);
  const auto used = own_processor_seconds(), since = wall_seconds();
  until(settled + idle);
  const auto percent = (own_processor_seconds() - used) / (wall_seconds() - since) * 100;
  const auto all = resident_mb(), own = private_mb();
  until(settled + idle + 1);
  return {{"seen_s", seen},          {"begun_s", begun},   {"meeting_cpu_s", used_until_seen},
          {"idle_percent", percent}, {"lost_peers", lost}, {"resident_mb", all},
          {"private_mb", own}};
}

}  // namespace rubicon::bench
