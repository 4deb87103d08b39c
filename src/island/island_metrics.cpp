#include "island/island_metrics.h"

#include <fmt/format.h>

#include <tuple>

#include "model/point_keys.h"

namespace rubicon::island {

namespace {

constexpr Duration kMetricsPause = std::chrono::seconds(1);

}  // namespace

IslandMetrics::IslandMetrics(Scheduler& scheduler, TupleSpace& space, std::string prefix)
    : scheduler_(scheduler), space_(space), prefix_(std::move(prefix)) {}

void IslandMetrics::start() {
  const auto clock = model::IslandKey{prefix_}.property("clock");
  std::ignore = space_.declare(clock);
  clock_watch_ = space_.watch_demand({space_.self(), clock}, [this](const tuples::Demand& demand) {
    clock_wanted_ = demand.wanted;
    if (clock_wanted_) publish_clock();
  });
  publish();
}

void IslandMetrics::publish() {
  timer_ = scheduler_.after(kMetricsPause, [this] { publish(); });
  std::map<std::string, std::string> now;
  for (const auto& source : sources_) source(Publish(now));
  for (const auto& [name, value] : now) {
    const auto before = published_.find(name);
    if (before != published_.end() && before->second == value) continue;
    std::ignore = space_.set(model::IslandKey{prefix_}.property(name), value);
  }
  for (const auto& [name, value] : published_) {
    if (!now.contains(name)) std::ignore = space_.erase(model::IslandKey{prefix_}.property(name));
  }
  published_ = std::move(now);
  if (clock_wanted_) publish_clock();
}

void IslandMetrics::publish_clock() {
  std::ignore = space_.set(model::IslandKey{prefix_}.property("clock"),
                           fmt::format("{:.6f}", base::to_seconds(scheduler_.wall_now())));
}

}  // namespace rubicon::island
