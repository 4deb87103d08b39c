#include "networks/knx/bus_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "model/key.h"

namespace rubicon::networks::knx {

namespace {

using namespace std::chrono_literals;

/// A command that could not leave for so long is given up: the island's command desk does so too.
constexpr Duration kCommandLifetime = 5s;
/// Actuators that are already as commanded often stay silent: then they are asked.
constexpr Duration kReportTime = 1s;

}  // namespace

BusPoints::BusPoints(network::NetworkHost& host, GroupReads::Options reads, Say say)
    : host_(host),
      say_(std::move(say)),
      reads_(host.scheduler(), reads, [this](GroupAddress address) { no_answer(address); }) {}

void BusPoints::take(PointTable table) {
  PointTable before = std::exchange(table_, std::move(table));
  reads_.clear();
  periodic_.clear();
  verifying_.clear();
  for (auto& point : table_.points()) {
    const auto* known = before.find(point.address, point.id);
    if (!known || known->source() != point.source()) continue;
    point.wanted = known->wanted;
    point.heard_at = known->heard_at;
  }
  if (!begun_) return;
  for (const auto& [device, content] : before.devices()) {
    if (!table_.devices().contains(device)) host_.deliver(device, model::Leave{"taken out of the configuration"});
  }
  for (const auto& [device, content] : table_.devices()) join(device);
  if (line_ != nullptr) ask_marked();
}

/// The devices are there before any contact: keys are known before the first telegram.
void BusPoints::begin() {
  if (std::exchange(begun_, true)) return;
  for (const auto& [device, content] : table_.devices()) join(device);
}

void BusPoints::join(const std::string& device) {
  host_.deliver(device, table_.join_of(device));
}

void BusPoints::line_up(Line& line) {
  line_ = &line;
  for (auto& point : table_.points()) point.heard_at = {};
  reads_.use(&line);
  ask_marked();
}

void BusPoints::line_down() {
  line_ = nullptr;
  reads_.use(nullptr);
  periodic_.clear();
}

void BusPoints::ask_marked() {
  using When = ReadRule::When;
  for (std::size_t i = 0; i < table_.points().size(); ++i) {
    const auto& point = table_.points()[i];
    if (!point.readable() || point.group.read.when == When::kNever) continue;
    const bool marked = point.group.read.when != When::kDemand;
    if (point.wanted || marked) ask(point, point.wanted);
    if (point.group.read.when == When::kEvery || point.group.read.when == When::kExpire) plan(i);
  }
}

void BusPoints::plan(std::size_t index) {
  const auto period = table_.points()[index].group.read.period;
  periodic_[index] = host_.scheduler().after(period, [this, index] { due(index); });
}

/// Of `expire`, only silence is a reason to ask; of `every`, only somebody who wants to know.
void BusPoints::due(std::size_t index) {
  const auto& point = table_.points()[index];
  const auto& rule = point.group.read;
  const auto now = host_.scheduler().now();
  if (rule.when == ReadRule::When::kExpire && point.heard_at != SteadyTime{} && point.heard_at + rule.period > now) {
    periodic_[index] = host_.scheduler().at(point.heard_at + rule.period, [this, index] { due(index); });
    return;
  }
  if (rule.when == ReadRule::When::kExpire || point.wanted) ask(point, false);
  plan(index);
}

bool BusPoints::heard(const Telegram& telegram) {
  if (!table_.knows(telegram.destination)) return false;
  if (telegram.service == Service::kRead) return true;
  reads_.heard(telegram.destination);
  for (const auto index : table_.heard_on(telegram.destination)) update(table_.points()[index], telegram.payload);
  return true;
}

void BusPoints::update(BoundPoint& point, PayloadView payload) {
  auto value = value_of(point, payload);
  if (!value) {
    ++counters_.bad_values;
    say_(fmt::format("value {}", to_string(point.source())),
         fmt::format("{}: {}: {}", to_string(point.source()), base::to_hex(payload.bytes), value.error().text));
  }
  ++counters_.readings;
  point.heard_at = host_.scheduler().now();
  verifying_.erase({point.address, point.id});
  model::Updates updates;
  updates.readings.push_back({point.id, value ? std::move(*value) : Value(), {}});
  host_.deliver(point.address, std::move(updates));
}

Result<void> BusPoints::sample(const std::string& device, const model::Sample& wish) {
  const auto found = table_.devices().find(device);
  if (found == table_.devices().end())
    return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(device)));
  for (const auto index : found->second.points) {
    auto& point = table_.points()[index];
    const bool before =
        std::exchange(point.wanted, std::find(wish.points.begin(), wish.points.end(), point.id) != wish.points.end());
    const bool knows = point.heard_at != SteadyTime{};
    if (point.wanted && !before && !knows && point.readable() && point.group.read.when != ReadRule::When::kNever)
      ask(point, true);
  }
  host_.deliver(device, model::Acknowledge{wish.request, model::Outcome::kSent, {}});
  return {};
}

Result<void> BusPoints::actuate(const std::string& device, const model::Actuate& command) {
  const auto* point = table_.find(device, command.point);
  if (!point) return fail(ErrorCode::kNotFound, fmt::format("no such point of device {}", model::quoted(device)));
  if (point->id.kind != Kind::kActuator) return fail(ErrorCode::kUnsupported, "a sensor takes no commands");
  auto payload = payload_of(*point, command.value);
  if (!payload) return fail(payload.error());
  if (line_ == nullptr) return fail(ErrorCode::kUnreachable, "the line to the bus is down");
  Telegram telegram;
  telegram.destination = point->group.address;
  telegram.payload = std::move(*payload);
  ++counters_.commands;
  line_->send(std::move(telegram), host_.scheduler().now() + kCommandLifetime,
              [this, device, command, alive = std::weak_ptr<bool>(alive_)](Sent outcome, std::string_view why) {
                if (alive.lock()) sent(device, command, outcome, why);
              });
  return {};
}

/// L_Data.con makes a command sent; whether it had an effect, the state address says.
void BusPoints::sent(const std::string& device, const model::Actuate& command, Sent outcome, std::string_view why) {
  // Without L_Data.con the interface has it, at least: where there is a report, that decides.
  const auto* point = table_.find(device, command.point);
  const bool open = outcome == Sent::kUnconfirmed && point && point->group.state;
  if (outcome == Sent::kSent || open) {
    host_.deliver(device, model::Acknowledge{command.request, model::Outcome::kSent, {}});
    return verify(device, command.point);
  }
  ++counters_.failed_commands;
  const auto kind = outcome == Sent::kRefused ? model::Outcome::kRefused : model::Outcome::kFailed;
  host_.deliver(device, model::Acknowledge{command.request, kind, std::string(why)});
}

void BusPoints::verify(const std::string& device, const PointId& id) {
  const auto* point = table_.find(device, id);
  if (!point || !point->group.state || point->group.read.when == ReadRule::When::kNever) return;
  verifying_[{device, id}] = host_.scheduler().after(kReportTime, [this, key = std::pair(device, id)] {
    const auto* silent = table_.find(key.first, key.second);
    if (silent) ask(*silent, true);
    verifying_.erase(key);
  });
}

void BusPoints::no_answer(GroupAddress address) {
  say_(fmt::format("no answer {}", to_string(address)),
       fmt::format("nobody on the bus answers for {}: no device has its read flag set, or the one that has is off",
                   to_string(address)));
}

}  // namespace rubicon::networks::knx
