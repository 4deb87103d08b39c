#include "proxy/demand.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::proxy {

namespace {

/// Devices checked in one turn of the loop.
constexpr std::size_t kOrdersATurn = 1000;
constexpr std::chrono::milliseconds kMaxPeriod = std::chrono::hours(24);
constexpr Duration kBusyPause = std::chrono::seconds(1);
constexpr Duration kOverduePause = std::chrono::seconds(10);

bool is_overdue(const Device& device) {
  return device.status == DeviceStatus::kReachable && device.sampling.refusal.empty() &&
         std::any_of(device.points.begin(), device.points.end(),
                     [](const Point& point) { return point.demand.wanted && point.quality == Quality::kStale; });
}

}  // namespace

Demand::Demand(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Liveness& liveness)
    : context_(context),
      directory_(directory),
      mirror_(mirror),
      liveness_(liveness),
      next_turn_(context.scheduler, [this] { check_queued(); }) {}

void Demand::on_demand(const tuples::Demand& demand) {
  const auto place = mirror_.place_of(demand.tuple);
  auto* point = place.point;
  if (!point || (point->id.kind != Kind::kSensor && !point->details->capability->sampled)) return;
  if (demand.wanted && !point->demand.wanted) point->demand.since = context_.clock.now().steady;
  point->demand.wanted = demand.wanted;
  point->demand.interval = demand.interval;
  point->demand.named = demand.named;
  check_next_turn(*place.device);
}

void Demand::repeat(Device& device) {
  device.sampling.repeat |= !device.sampling.points.empty() || device.sampling.unsure;
  check_next_turn(device);
}

void Demand::overdue(Device& device) {
  if (!is_overdue(device) || std::exchange(device.sampling.overdue, true)) return;
  overdue_.push_back(device.number);
  repeat(device);
  if (overdue_timer_.pending()) return;
  overdue_timer_ = context_.scheduler.after(kOverduePause, [this] { repeat_overdue(); });
}

void Demand::repeat_overdue() {
  std::erase_if(overdue_, [this](DeviceNumber number) {
    auto* device = directory_.find(number);
    if (device && is_overdue(*device)) {
      repeat(*device);
      return false;
    }
    if (device) device->sampling.overdue = false;
    return true;
  });
  if (overdue_.empty()) return;
  overdue_timer_ = context_.scheduler.after(kOverduePause, [this] { repeat_overdue(); });
}

void Demand::changed(Device& device) {
  check_next_turn(device);
}

void Demand::reset(Device& device) {
  for (auto& point : device.points) point.demand.wanted = false;
}

void Demand::stop(Device& device) {
  reset(device);
  send_if_changed(device);
}

void Demand::check_next_turn(Device& device) {
  if (std::exchange(device.sampling.queued, true)) return;
  queue_.push_back(device.number);
  next_turn_.request();
}

void Demand::check_queued() {
  const auto count = std::min(queue_.size(), kOrdersATurn);
  for (std::size_t i = 0; i < count; ++i) {
    auto* device = directory_.find(queue_[i]);
    if (!device) continue;
    device->sampling.queued = false;
    send_if_changed(*device);
  }
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(count));
  if (!queue_.empty()) next_turn_.request();
}

std::chrono::milliseconds Demand::period_of(const Device& device) const {
  Duration shortest = Duration::max();
  for (const auto& point : device.points) {
    if (!point.demand.wanted) continue;
    if (point.demand.named != Duration::zero()) shortest = std::min(shortest, point.demand.named);
    if (point.demand.interval == Duration::zero()) shortest = std::min(shortest, Duration(device.rate));
  }
  if (shortest == Duration::max()) return std::chrono::milliseconds(0);
  return std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(shortest), std::chrono::milliseconds(1),
                    kMaxPeriod);
}

void Demand::send_if_changed(Device& device) {
  auto& sampling = device.sampling;
  if (!can_send(*device.network)) return;  // repeated when the line is up
  std::vector<PointId> points;
  for (const auto& point : device.points) {
    if (point.demand.wanted) points.push_back(point.id);
  }
  const auto period = period_of(device);
  const bool same = points == sampling.points && period == sampling.period;
  if (!std::exchange(sampling.repeat, false) && same) return;
  if (period < sampling.period || sampling.points.empty()) sampling.faster_at = context_.clock.now().steady;
  sampling.points = std::move(points);
  sampling.period = period;
  send(device);
}

void Demand::send(Device& device) {
  auto& sampling = device.sampling;
  requests_.erase(sampling.request);
  sampling.request = context_.next_request();
  sampling.unsure = true;
  requests_.emplace(sampling.request, device.number);
  Message message;
  message.source.island = context_.space.self();
  message.destination = {context_.space.self(), device.network->id, device.address};
  message.body = model::Sample{sampling.request, sampling.points, sampling.period};
  context_.gateway.send(std::move(message));
  liveness_.watch(device);
}

bool Demand::acknowledged(const model::Acknowledge& answer) {
  const auto found = requests_.find(answer.request);
  if (found == requests_.end()) return false;
  auto* device = directory_.find(found->second);
  requests_.erase(found);
  if (!device) return true;
  device->sampling.request = 0;
  if (answer.outcome == model::Outcome::kSent) {
    device->sampling.unsure = false;
    note_refusal(*device, {});
  } else if (answer.outcome == model::Outcome::kBusy) {
    device->sampling.repeat = true;
    busy_.push_back(device->number);
    if (busy_timer_.pending()) return true;
    busy_timer_ = context_.scheduler.after(kBusyPause, [this] {
      for (const auto number : std::exchange(busy_, {})) {
        if (auto* again = directory_.find(number)) check_next_turn(*again);
      }
    });
  } else {
    note_refusal(*device, fmt::format("sampling {}: {}", to_string(answer.outcome), answer.text));
  }
  return true;
}

void Demand::note_refusal(Device& device, std::string why) {
  if (device.sampling.refusal == why) return;
  device.sampling.refusal = std::move(why);
  for (auto& point : device.points) {
    if (point.demand.wanted) mirror_.publish_status(device, point);
  }
  liveness_.watch(device);
}

void Demand::forget(const Device& device) {
  requests_.erase(device.sampling.request);
}

}  // namespace rubicon::proxy
