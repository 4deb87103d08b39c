#include "networks/knx/bus_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::networks::knx {

namespace {

using namespace std::chrono_literals;

/// Lifetime of a command for which the island sets none.
constexpr Duration kCommandLifetime = 5s;
/// An actuator that already has the commanded state often reports nothing, so the island reads it after this time.
constexpr Duration kReportTime = 1s;
/// A value younger than this need not be read (knx.md, section 8: expire).
constexpr Duration kFresh = 60min;

/// A report may differ from the command in its digits; words are exact.
bool is_rounded(const BoundPoint& point) {
  return point.dpt != nullptr && point.dpt->words.empty();
}

}  // namespace

BusPoints::BusPoints(network::NetworkHost& host, GroupReads::Options reads, Report report)
    : host_(host),
      report_(std::move(report)),
      reads_(host.scheduler(), reads,
             [this](wire::GroupAddress address, std::string_view why) { no_answer(address, why); }) {}

void BusPoints::set_table(PointTable table) {
  PointTable before = std::exchange(table_, std::move(table));
  periodic_.clear();
  for (auto& point : table_.points()) {
    const auto* known = before.find(point.address, point.id);
    if (!known || known->source() != point.source()) continue;
    point.subscribed = known->subscribed;
    point.updated_at = known->updated_at;
  }
  reads_.keep([this](wire::GroupAddress address) { return !table_.listeners_of(address).empty(); });
  std::erase_if(commanded_, [this](const auto& one) { return !table_.find(one.first.first, one.first.second); });
  if (!begun_) return;
  for (const auto& [device, content] : before.devices()) {
    if (!table_.devices().contains(device)) host_.deliver(device, model::Leave{"removed from the configuration"});
  }
  for (const auto& [device, content] : table_.devices()) join(device);
  if (line_ != nullptr) read_all();
}

/// Devices join before any contact, so that their keys exist before the first telegram.
void BusPoints::begin() {
  if (std::exchange(begun_, true)) return;
  for (const auto& [device, content] : table_.devices()) join(device);
}

void BusPoints::join(const std::string& device) {
  host_.deliver(device, table_.join_of(device));
}

void BusPoints::line_up(line::Line& line) {
  line_ = &line;
  for (auto& point : table_.points()) point.updated_at = {};
  reads_.use(&line);
  read_all();
}

void BusPoints::line_down() {
  line_ = nullptr;
  reads_.use(nullptr);
  periodic_.clear();
}

void BusPoints::read_all() {
  using When = groups::ReadRule::When;
  for (std::size_t i = 0; i < table_.points().size(); ++i) {
    const auto& point = table_.points()[i];
    if (!point.readable() || point.group.read.when == When::kNever) continue;
    const bool configured = point.group.read.when != When::kDemand;
    if ((point.subscribed || configured) && point.updated_at == SteadyTime{})
      read(point, point.subscribed ? GroupReads::Rank::kReconnected : GroupReads::Rank::kConfigured);
    if (point.group.read.when == When::kEvery || point.group.read.when == When::kExpire) start_period(i);
  }
}

void BusPoints::start_period(std::size_t index) {
  const auto period = table_.points()[index].group.read.period;
  periodic_[index] = host_.scheduler().after(period, [this, index] { period_ended(index); });
}

/// `expire` reads only after silence, `every` only if there is a subscriber.
void BusPoints::period_ended(std::size_t index) {
  const auto& point = table_.points()[index];
  const auto& rule = point.group.read;
  const auto now = host_.scheduler().now();
  if (rule.when == groups::ReadRule::When::kExpire && point.updated_at != SteadyTime{} &&
      point.updated_at + rule.period > now) {
    periodic_[index] = host_.scheduler().at(point.updated_at + rule.period, [this, index] { period_ended(index); });
    return;
  }
  if (rule.when == groups::ReadRule::When::kExpire || point.subscribed) read(point, GroupReads::Rank::kConfigured);
  start_period(index);
}

bool BusPoints::receive(const wire::Telegram& telegram, const BoundPoint* except) {
  if (!table_.contains(telegram.destination)) return false;
  if (telegram.service == wire::Service::kRead) return true;
  reads_.received(telegram.destination);
  for (const auto& listener : table_.listeners_of(telegram.destination)) {
    auto& point = table_.points()[listener.point];
    if (&point != except) update(point, telegram.payload);
  }
  return true;
}

void BusPoints::update(BoundPoint& point, wire::PayloadView payload) {
  auto value = value_of(point, payload);
  std::string why;
  ++counters_.readings;
  if (value) {
    point.updated_at = host_.scheduler().now();
    const auto commanded = commanded_.find({point.address, point.id});
    if (commanded != commanded_.end()) {
      const auto& bytes = commanded->second.payload.bytes;
      const bool same = std::equal(bytes.begin(), bytes.end(), payload.bytes.begin(), payload.bytes.end());
      if (same && is_rounded(point)) *value = commanded->second.value;
      if (same) commanded->second.verify.cancel();
      if (!same && !commanded->second.verify.pending()) commanded_.erase(commanded);
    }
  } else {
    ++counters_.bad_values;
    why = fmt::format("telegram {}: {}", base::to_hex(payload.bytes), value.error().text);
    report_({kBadValue, point.source(), why});
  }
  model::Updates updates;
  updates.readings.push_back({point.id, value ? std::move(*value) : Value(), {}, std::move(why)});
  host_.deliver(point.address, std::move(updates));
}

/// Older values are read again for a new subscriber.
bool BusPoints::is_fresh(const BoundPoint& point) const {
  return point.updated_at != SteadyTime{} && point.updated_at + kFresh > host_.scheduler().now();
}

Result<void> BusPoints::sample(const std::string& device, const model::Sample& request) {
  const auto found = table_.devices().find(device);
  if (found == table_.devices().end())
    return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(device)));
  for (const auto index : found->second.points) {
    auto& point = table_.points()[index];
    const bool before = std::exchange(
        point.subscribed, std::find(request.points.begin(), request.points.end(), point.id) != request.points.end());
    const bool may_read = point.readable() && point.group.read.when != groups::ReadRule::When::kNever;
    if (point.subscribed && !before && may_read && !is_fresh(point)) read(point, GroupReads::Rank::kSubscribed);
  }
  host_.deliver(device, model::Acknowledge{request.request, model::Outcome::kSent, {}});
  return {};
}

Result<void> BusPoints::actuate(const std::string& device, const model::Actuate& command) {
  const auto* point = table_.find(device, command.point);
  if (!point) return fail(ErrorCode::kNotFound, fmt::format("no such point of device {}", model::quoted(device)));
  if (point->id.kind != Kind::kActuator) return fail(ErrorCode::kUnsupported, "a sensor does not accept commands");
  auto payload = payload_of(*point, command.value);
  if (!payload) return fail(payload.error());
  if (line_ == nullptr) return fail(ErrorCode::kUnreachable, "the line to the bus is down");
  wire::Telegram telegram;
  telegram.destination = point->group.address;
  telegram.priority = wire::Priority::kNormal;  // sent before reads and exposed tuples
  telegram.payload = *payload;
  ++counters_.commands;
  commanded_[{device, command.point}] = {command.request, std::move(*payload), command.value, {}};
  const bool limited = command.time_to_live.count() > 0;
  line_->send(
      telegram, host_.scheduler().now() + (limited ? Duration(command.time_to_live) : kCommandLifetime),
      [this, device, command, telegram, watch = lifetime_.watch()](line::SendOutcome outcome, std::string_view why) {
        if (watch.ended()) return;
        sent(device, command, outcome, why);
        if (outcome == line::SendOutcome::kSent) receive(telegram, table_.find(device, command.point));
      });
  return {};
}

/// L_Data.con means that the command was sent; the state address tells whether it had an effect. Without L_Data.con the
/// interface has at least accepted it.
void BusPoints::sent(const std::string& device, const model::Actuate& command, line::SendOutcome outcome,
                     std::string_view why) {
  if (outcome == line::SendOutcome::kSent || outcome == line::SendOutcome::kUnconfirmed) {
    host_.deliver(device, model::Acknowledge{command.request, model::Outcome::kSent,
                                             outcome == line::SendOutcome::kSent ? std::string() : std::string(why)});
    return verify(device, command);
  }
  ++counters_.failed_commands;
  const auto commanded = commanded_.find({device, command.point});
  if (commanded != commanded_.end() && commanded->second.request == command.request) commanded_.erase(commanded);
  const auto kind = outcome == line::SendOutcome::kRefused ? model::Outcome::kRefused : model::Outcome::kFailed;
  host_.deliver(device, model::Acknowledge{command.request, kind, std::string(why)});
}

/// Reads the state unless it is reported in time. A newer command of the point has its own verification.
void BusPoints::verify(const std::string& device, const model::Actuate& command) {
  const auto* point = table_.find(device, command.point);
  const auto commanded = commanded_.find({device, command.point});
  if (!point || commanded == commanded_.end() || commanded->second.request != command.request) return;
  if (!point->group.state || point->group.read.when == groups::ReadRule::When::kNever)
    return void(commanded_.erase(commanded));
  commanded->second.verify = host_.scheduler().after(kReportTime, [this, key = commanded->first] {
    if (const auto* silent = table_.find(key.first, key.second)) read(*silent, GroupReads::Rank::kVerify);
  });
}

void BusPoints::no_answer(wire::GroupAddress address, std::string_view why) {
  report_({kUnanswered, address,
           why.empty() ? std::string("no device on the bus answers a read: none has the read flag of this address set, "
                                     "or the one that has is off")
                       : fmt::format("cannot be read: {}", why)});
}

}  // namespace rubicon::networks::knx
