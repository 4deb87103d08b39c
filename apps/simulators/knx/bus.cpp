#include "apps/simulators/knx/bus.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace rubicon::knx_simulator {

namespace {

using namespace std::chrono_literals;
using namespace networks::knx::wire;
using networks::knx::dpt::Dpt;

constexpr Duration kAnswerTime = 20ms, kReportTime = 50ms, kRampStep = 1s;
constexpr std::uint16_t kFirstDevice = 0x1101, kDevices = 199;  ///< 1.1.1 to 1.1.199; then from the front again

double number_of(const Dpt& type, const Payload& value) {
  const auto decoded = decode(type, value);
  if (!decoded) return 0;
  if (const auto* whole = std::get_if<std::int64_t>(&*decoded)) return static_cast<double>(*whole);
  const auto* real = std::get_if<double>(&*decoded);
  return real ? *real : 0;
}

double share_of(SteadyTime from, SteadyTime to, Duration whole) {
  return static_cast<double>((to - from).count()) / static_cast<double>(whole.count());
}

}  // namespace

Bus::Bus(Scheduler& scheduler, std::vector<Group> groups, std::uint64_t seed) : scheduler_(scheduler), random_(seed) {
  std::uint16_t index = 0;
  for (auto& group : groups) {
    auto& device = devices_[group.address];
    device.address = IndividualAddress(static_cast<std::uint16_t>(kFirstDevice + index++ % kDevices));
    device.base = number_of(*group.type, group.value);
    device.group = std::move(group);
  }
}

void Bus::start() {
  started_ = scheduler_.now();
  for (auto& [address, device] : devices_) {
    if (device.group.every > Duration{})
      device.sensor = scheduler_.after(device.group.every, [this, &device = device] { measure(device); });
  }
}

std::size_t Bus::attach(Send send) {
  lines_.push_back(std::move(send));
  return lines_.size() - 1;
}

Bus::Device* Bus::find(GroupAddress group) {
  const auto found = devices_.find(group);
  return found == devices_.end() ? nullptr : &found->second;
}

const Payload* Bus::value(GroupAddress group) const {
  const auto found = devices_.find(group);
  return found == devices_.end() ? nullptr : &found->second.group.value;
}

void Bus::received(const Telegram& telegram, std::size_t line) {
  for (std::size_t other = 0; other < lines_.size(); ++other) {
    if (other != line) lines_[other](telegram);
  }
  auto* device = find(telegram.destination);
  if (device == nullptr || scheduler_.now() < silent_until_) {
    ++counters_.ignored;
    return;
  }
  if (telegram.service == Service::kRead) return answer(*device);
  if (!decode(*device->group.type, telegram.payload)) {
    ++counters_.ignored;
    return;
  }
  ++counters_.written;
  keep(*device, telegram.payload);
}

void Bus::keep(Device& device, const Payload& value) {
  device.group.value = value;
  device.base = number_of(*device.group.type, value);
  if (device.group.state) device.reporting = scheduler_.after(kReportTime, [this, &device] { report_state(device); });
}

void Bus::report_state(const Device& device) {
  auto* state = find(*device.group.state);
  if (state == nullptr) return;
  state->group.value = device.group.value;
  send(device, *device.group.state, Service::kWrite, device.group.value);
}

void Bus::answer(Device& device) {
  if (!device.group.readable) {
    ++counters_.ignored;
    return;
  }
  device.answering = scheduler_.after(kAnswerTime, [this, &device] {
    ++counters_.answered;
    send(device, device.group.address, Service::kResponse, device.group.value);
  });
}

void Bus::send(const Device& device, GroupAddress group, Service service, const Payload& value) {
  if (scheduler_.now() < silent_until_) return;
  ++counters_.sent;
  Telegram telegram;
  telegram.service = service;
  telegram.destination = group;
  telegram.payload = value;
  telegram.source = device.address;
  for (const auto& line : lines_) line(telegram);
}

void Bus::write(GroupAddress group, const Payload& value) {
  auto* device = find(group);
  if (device == nullptr) return;
  send(*device, group, Service::kWrite, value);
  keep(*device, value);
}

void Bus::set(GroupAddress group, const Payload& value) {
  auto* device = find(group);
  if (device == nullptr) return;
  device->group.value = value;
  device->base = number_of(*device->group.type, value);
}

void Bus::read(GroupAddress group) {
  if (const auto* device = find(group)) send(*device, group, Service::kRead, {});
}

void Bus::silence(Duration span) {
  silent_until_ = scheduler_.now() + span;
}

void Bus::ramp(GroupAddress group, double from, double to, Duration span) {
  auto* device = find(group);
  if (device == nullptr) return;
  device->ramp.from = from;
  device->ramp.to = to;
  device->ramp.began = scheduler_.now();
  device->ramp.span = span;
  step(*device);
}

void Bus::step(Device& device) {
  auto& ramp = device.ramp;
  const double share = std::min(1.0, share_of(ramp.began, scheduler_.now(), ramp.span));
  write_number(device, ramp.from + (ramp.to - ramp.from) * share);
  if (share >= 1) return;
  const auto next = std::min(scheduler_.now() + kRampStep, ramp.began + ramp.span);
  ramp.timer = scheduler_.at(next, [this, &device] { step(device); });
}

void Bus::measure(Device& device) {
  device.sensor = scheduler_.after(device.group.every, [this, &device] { measure(device); });
  const auto& group = device.group;
  if (group.period == Duration{} && group.noise == 0) return send(device, group.address, Service::kWrite, group.value);
  const double base = device.base;
  write_number(device, measured(device));
  device.base = base;
}

/// What a sensor with noise or a wave measures now.
double Bus::measured(const Device& device) {
  const auto& group = device.group;
  double number = device.base;
  if (group.period > Duration{}) {
    const double turn = 2 * std::numbers::pi * share_of(started_, scheduler_.now(), group.period);
    number = (group.low + group.high) / 2 + (group.high - group.low) / 2 * std::sin(turn);
  }
  if (group.noise > 0) number += std::uniform_real_distribution<>(-group.noise, group.noise)(random_);
  return number;
}

void Bus::write_number(Device& device, double number) {
  const auto& type = *device.group.type;
  const auto value = encode(type, std::clamp(number, type.minimum, type.maximum));
  if (value) write(device.group.address, *value);
}

}  // namespace rubicon::knx_simulator
