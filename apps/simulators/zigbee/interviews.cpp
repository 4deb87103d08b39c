#include "apps/simulators/zigbee/interviews.h"

#include <algorithm>

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;
using Stage = RadioDevice::Stage;

/// What the record has after each answer of the device; the recorded bridge needed nine for a lamp.
constexpr std::array kStages{Stage::kEndpoints, Stage::kEndpoints, Stage::kModel, Stage::kManufacturer, Stage::kPower,
                             Stage::kPower,     Stage::kPower,     Stage::kDate,  Stage::kDate};
constexpr Duration kAnswer = 14ms;
constexpr int kAnswersBeforeFailure = 3;

}  // namespace

void Interviews::add(RadioDevice& device, bool fails) {
  if (world_.joining()) return begin(device, fails);
  waiting_.push_back({device.address(), fails});
}

void Interviews::open() {
  const auto waiting = std::exchange(waiting_, {});
  Duration after = kAnswer;
  for (const auto& one : waiting) {
    auto* device = world_.find(one.address);
    if (device == nullptr) continue;
    world_.later(*device, after, [this, fails = one.fails](RadioDevice& found) { begin(found, fails); });
    after += kAnswer;
  }
}

void Interviews::forget(const std::string& address) {
  std::erase_if(waiting_, [&](const auto& one) { return one.address == address; });
}

void Interviews::begin(RadioDevice& device, bool fails) {
  device.joined = true;
  world_.publish_availability(device);
  world_.hear(device);
  world_.publish_devices();
  world_.publish_devices();
  world_.publish_event("device_joined", device);
  world_.publish_event("device_interview", device, {{"status", "started"}});
  world_.later(device, kAnswer, [this, fails](RadioDevice& found) { ask(found, fails, 0); });
}

void Interviews::repeat(RadioDevice& device) {
  world_.publish_event("device_interview", device, {{"status", "started"}});
  world_.later(device, kAnswer, [this](RadioDevice& found) { ask(found, false, 0); });
}

void Interviews::ask(RadioDevice& device, bool fails, int question) {
  world_.hear(device);
  const bool known = device.usable();
  if (!known) device.set_stage(kStages[static_cast<std::size_t>(question)]);
  const int last = fails ? kAnswersBeforeFailure : static_cast<int>(kStages.size()) - 1;
  if (question < last)
    return world_.later(device, kAnswer,
                        [this, fails, question](RadioDevice& found) { ask(found, fails, question + 1); });
  if (fails) return world_.later(device, 10s, [this](RadioDevice& found) { fail_now(found); });
  succeed(device);
}

void Interviews::fail_now(RadioDevice& device) {
  device.set_stage(Stage::kFailed);
  world_.publish_devices();
  world_.publish_event("device_interview", device, {{"status", "failed"}});
}

void Interviews::succeed(RadioDevice& device) {
  if (!device.usable()) device.set_stage(Stage::kInterviewed);
  if (world_.options().nulls) device.know_nothing();
  world_.publish_devices();
  world_.publish_event("device_interview", device,
                       {{"status", "successful"}, {"supported", true}, {"definition", device.definition()}});
  world_.later(device, 100ms, [this](RadioDevice& found) { configure(found); });
}

void Interviews::configure(RadioDevice& device) {
  world_.hear(device);
  const bool reports = !device.model().endpoints.begin()->at("configured_reportings").empty();
  if (reports && !device.model().sleeps) {
    for (const auto& properties : device.by_cluster(device.measured())) world_.publish_report(device, properties);
  }
  device.set_stage(Stage::kConfigured);
  world_.publish_devices();
  world_.publish_info();
  world_.begin_period(device);
}

}  // namespace rubicon::zigbee_simulator
