#include "runtime/island_metrics.h"

#include <fmt/format.h>

#include <tuple>

namespace rubicon::runtime {

namespace {

constexpr Duration kPause = std::chrono::seconds(1);

}  // namespace

IslandMetrics::IslandMetrics(Scheduler& scheduler, TupleSpace& space, std::string prefix)
    : scheduler_(scheduler), space_(space), prefix_(std::move(prefix)) {}

void IslandMetrics::start() {
  publish();
}

void IslandMetrics::publish() {
  timer_ = scheduler_.after(kPause, [this] { publish(); });
  std::map<std::string, std::uint64_t> now;
  for (const auto& source : sources_) {
    source([&now](const std::string& name, std::uint64_t value) { now[name] = value; });
  }
  for (const auto& [name, value] : now) {
    const auto before = published_.find(name);
    if (before != published_.end() && before->second == value) continue;
    std::ignore = space_.set(fmt::format("{}.property.{}.value", prefix_, name), std::to_string(value));
  }
  for (const auto& [name, value] : published_) {
    if (!now.contains(name)) std::ignore = space_.erase(fmt::format("{}.property.{}.value", prefix_, name));
  }
  published_ = std::move(now);
}

}  // namespace rubicon::runtime
