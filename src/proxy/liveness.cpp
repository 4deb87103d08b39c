#include "proxy/liveness.h"

#include <fmt/format.h>

#include <algorithm>

#include "proxy/tuple_text.h"

namespace rubicon::proxy {

namespace {

constexpr Duration kShortestDeadline = std::chrono::seconds(3);
constexpr Duration kLongestDeadline = std::chrono::hours(24 * 366);
/// Devices looked at in one turn of the loop.
constexpr int kDevicesATurn = 1000;

bool ages(const Point& point) {
  return point.id.kind == Kind::kSensor && !(point.type && point.type->report == model::Report::kEvent);
}

}  // namespace

std::optional<SteadyTime> stale_at(const Device& device, const Point& point) {
  if (const auto& own = point.details->capability->deadline) {
    return *own <= Duration::zero() ? std::nullopt : std::optional(point.heard_at + std::min(*own, kLongestDeadline));
  }
  if (!ages(point)) return std::nullopt;
  const auto silence = device.network->rules.silence;
  const bool sampled = point.wanted && device.sampling.refusal.empty();
  if (!sampled) return silence ? std::optional(point.heard_at + *silence) : std::nullopt;
  const auto patience = std::max<Duration>(3 * device.sampling.period, kShortestDeadline);
  // A sensor that is just beginning to be sampled gets its first period, but no longer than unsampled ones have.
  auto grace = std::max(point.wanted_at, device.sampling.faster_at) + patience;
  if (silence) grace = std::min(grace, point.heard_at + *silence);
  return std::max(point.heard_at + patience, grace);
}

std::optional<SteadyTime> probe_at(const Device& device) {
  const auto& rules = device.network->rules;
  if (!rules.probes || !can_send(*device.network)) return std::nullopt;
  const bool heard = device.status == DeviceStatus::kReachable;
  if (!heard && device.probed_at == SteadyTime{}) return SteadyTime{};
  if (!rules.silence) return std::nullopt;
  if (!heard) return device.probed_at + *rules.silence / 2;
  return std::max(device.heard_at + *rules.silence / 2, device.probed_at + *rules.silence / 4);
}

Liveness::Liveness(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Calls calls)
    : context_(context),
      directory_(directory),
      mirror_(mirror),
      calls_(std::move(calls)),
      next_check_(context.scheduler, [this] { look_at_due(); }) {}

std::optional<SteadyTime> Liveness::next_look(const Device& device) const {
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
  if (const auto when = next_look(device)) arm(device, *when);
}

void Liveness::arm(Device& device, SteadyTime when) {
  if (when >= device.check_at) return;
  device.check_at = when;
  checks_.push({when, device.number});
  set_timer();
}

void Liveness::set_timer() {
  if (!checks_.empty()) next_check_.advance_to(checks_.top().when);
}

void Liveness::look_at_due() {
  const auto now = context_.clock.refresh().steady;
  for (int looked = 0; looked < kDevicesATurn && !checks_.empty() && checks_.top().when <= now; ++looked) {
    const auto check = checks_.top();
    checks_.pop();
    auto* device = directory_.find(check.device);
    if (!device || device->check_at != check.when) continue;  // gone, or armed again for an earlier time
    device->check_at = SteadyTime::max();
    look(*device, now);
    watch(*device);
  }
  set_timer();
}

void Liveness::look(Device& device, SteadyTime now) {
  bool aged = false;
  for (auto& point : device.points) {
    if (point.quality != Quality::kGood) continue;
    const auto due = stale_at(device, point);
    if (!due || *due > now) continue;
    mirror_.set_quality(device, point, Quality::kStale,
                        fmt::format("not heard for {}", seconds_text(now - point.heard_at)));
    aged = true;
  }
  if (aged) calls_.stale(device);
  if (const auto due = probe_at(device); due && *due <= now) {
    device.probed_at = now;
    calls_.probe(device);
  }
  const auto silence = device.network->rules.silence;
  if (!silence || device.status != DeviceStatus::kReachable || device.heard_at + *silence > now) return;
  device.status = DeviceStatus::kUnreachable;
  device.since = context_.clock.now().wall;
  device.reason = fmt::format("silent for {}", seconds_text(*silence));
  calls_.lost(device);
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
