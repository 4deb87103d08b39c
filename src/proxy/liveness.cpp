#include "proxy/liveness.h"

#include <fmt/format.h>

#include <algorithm>

#include "proxy/tuple_text.h"

namespace rubicon::proxy {

namespace {

constexpr Duration kMinDeadline = std::chrono::seconds(3);
constexpr Duration kMaxDeadline = std::chrono::hours(24 * 366);
/// Devices checked in one turn of the loop.
constexpr int kDevicesATurn = 1000;
/// So many checks beyond two for each device are left behind before they are looked for.
constexpr std::size_t kOutdated = 1000;

bool ages(const Point& point) {
  return point.id.kind == Kind::kSensor && !(point.type && point.type->report == model::Report::kEvent);
}

}  // namespace

std::optional<SteadyTime> stale_at(const Device& device, const Point& point) {
  if (const auto& own = point.details->capability->deadline) {
    return *own <= Duration::zero() ? std::nullopt : std::optional(point.heard_at + std::min(*own, kMaxDeadline));
  }
  if (!ages(point)) return std::nullopt;
  const auto silence = device.network->rules.silence;
  const bool sampled = point.demand.wanted && device.sampling.refusal.empty();
  if (!sampled) return silence ? std::optional(point.heard_at + *silence) : std::nullopt;
  const auto deadline = std::max<Duration>(3 * device.sampling.period, kMinDeadline);
  // A sensor that is newly sampled has one more deadline for its first value, but not longer than an unsampled one.
  auto grace = std::max(point.demand.since, device.sampling.faster_at) + deadline;
  if (silence) grace = std::min(grace, point.heard_at + *silence);
  return std::max(point.heard_at + deadline, grace);
}

std::optional<SteadyTime> probe_at(const Device& device) {
  const auto& rules = device.network->rules;
  if (!rules.probes || !can_send(*device.network)) return std::nullopt;
  const bool heard = device.status == DeviceStatus::kReachable;
  if (!heard && device.liveness.probed_at == SteadyTime{}) return SteadyTime{};
  if (!rules.silence) return std::nullopt;
  if (!heard) return device.liveness.probed_at + *rules.silence / 2;
  return std::max(device.heard_at + *rules.silence / 2, device.liveness.probed_at + *rules.silence / 4);
}

Liveness::Liveness(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Callbacks callbacks)
    : context_(context),
      directory_(directory),
      mirror_(mirror),
      callbacks_(std::move(callbacks)),
      next_check_(context.scheduler, [this] { check_due(); }) {}

std::optional<SteadyTime> Liveness::next_check_of(const Device& device) const {
  std::optional<SteadyTime> next;
  const auto earlier = [&next](std::optional<SteadyTime> when) {
    if (when && (!next || *when < *next)) next = when;
  };
  const auto silence = device.network->rules.silence;
  if (silence && device.status == DeviceStatus::kReachable) earlier(device.heard_at + *silence);
  earlier(probe_at(device));
  for (const auto& point : device.points) {
    if (point.quality == Quality::kGood) earlier(stale_at(device, point));
  }
  return next;
}

void Liveness::watch(Device& device) {
  if (const auto when = next_check_of(device)) arm(device, *when);
}

void Liveness::arm(Device& device, SteadyTime when) {
  if (when >= device.liveness.check_at) return;
  device.liveness.check_at = when;
  checks_.push({when, device.number});
  if (checks_.size() > 2 * directory_.size() + kOutdated) drop_outdated();
  set_timer();
}

/// A device whose check moved to an earlier time leaves the later one behind.
void Liveness::drop_outdated() {
  std::vector<Check> current;
  for (const auto& [id, network] : directory_.networks()) {
    for (const auto& device : network->devices.all()) {
      if (device->liveness.check_at != SteadyTime::max())
        current.push_back({device->liveness.check_at, device->number});
    }
  }
  checks_ = decltype(checks_)(std::greater<>(), std::move(current));
}

void Liveness::set_timer() {
  if (!checks_.empty()) next_check_.advance_to(checks_.top().when);
}

void Liveness::check_due() {
  const auto now = context_.clock.refresh().steady;
  for (int checked = 0; checked < kDevicesATurn && !checks_.empty() && checks_.top().when <= now; ++checked) {
    const auto due = checks_.top();
    checks_.pop();
    auto* device = directory_.find(due.device);
    if (!device || device->liveness.check_at != due.when) continue;  // removed, or armed for an earlier time since
    device->liveness.check_at = SteadyTime::max();
    check(*device, now);
    watch(*device);
  }
  set_timer();
}

void Liveness::check(Device& device, SteadyTime now) {
  bool aged = false;
  for (auto& point : device.points) {
    if (point.quality != Quality::kGood) continue;
    const auto due = stale_at(device, point);
    if (!due || *due > now) continue;
    mirror_.set_quality(device, point, Quality::kStale,
                        fmt::format("not heard for {}", seconds_text(now - point.heard_at)));
    aged = true;
  }
  if (aged) callbacks_.stale(device);
  if (const auto due = probe_at(device); due && *due <= now) {
    device.liveness.probed_at = now;
    callbacks_.probe(device);
  }
  const auto silence = device.network->rules.silence;
  if (!silence || device.status != DeviceStatus::kReachable || device.heard_at + *silence > now) return;
  device.status = DeviceStatus::kUnreachable;
  device.since = context_.clock.now().wall;
  device.reason = fmt::format("silent for {}", seconds_text(*silence));
  callbacks_.lost(device);
}

void Liveness::interrupted(Device& device, const std::string& reason) {
  for (auto& point : device.points) {
    if (point.id.kind == Kind::kProperty) continue;
    if (point.quality != Quality::kGood && point.quality != Quality::kAssumed) continue;
    point.quality = Quality::kStale;
    point.since = context_.clock.now().wall;
    point.details->reason = reason;
  }
  mirror_.all_points(device);
}

}  // namespace rubicon::proxy
