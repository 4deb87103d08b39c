#include "networks/zigbee/devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

constexpr std::string_view kNotThereYet = "Zigbee2MQTT is not there yet";

std::string model_of(const bridge::DeviceRecord& record) {
  return record.vendor.empty() || record.model.empty() ? record.vendor + record.model
                                                       : record.vendor + " " + record.model;
}

}  // namespace

Devices::Devices(network::NetworkHost& host, const TypeCatalogue& types, const ZigbeeOptions& options,
                 bridge::Topics& topics, BrokerLine& line, std::function<void()> changed)
    : host_(host),
      types_(types),
      topics_(topics),
      line_(line),
      report_(std::move(changed)),
      log_(host.limited_log()),
      poll_places_(host.scheduler(), options.polls_per_second),
      down_(kNotThereYet),
      update_groups_(host.scheduler(), [this] { update_groups(); }),
      inventory_(
          host.scheduler(), options.most_devices,
          {.changed = [this](const bridge::DeviceRecord& record) { this->changed(record); },
           .left = [this](const std::string& address, const std::string& reason) { left(address, reason); },
           .waiting = [this](const bridge::DeviceRecord& record, const std::string& why) { waiting(record, why); },
           .unreadable = [this](const Error& error) { unreadable(error); },
           .compared =
               [this] {
                 listed_ = true;
                 report_();
               }}) {
  if (const auto* type = types.find("linkQuality")) link_quality_ = type->id;
}

void Devices::apply(const bridge::Topics::Filters& filters) {
  for (const auto& filter : filters.added) std::ignore = line_.subscribe(filter);
  for (const auto& filter : filters.removed) std::ignore = line_.unsubscribe(filter);
}

void Devices::changed(const bridge::DeviceRecord& record) {
  const auto& address = record.address;
  apply(topics_.put(address, record.name));
  problems_.erase(address);
  unusable_.erase(address);
  if (auto why = topics_.conflict(address); !why.empty()) {
    log_.warning("name " + address, why);
    problems_[address] = std::move(why);
  }
  auto& entity = entities_[address];
  const bool same_leaves = entity.device && entity.device->record().leaves == record.leaves;
  if (!record.is_group() && !same_leaves) member_changed(address);
  if (!entity.device) {
    ++counters_.joins;
    entity.device = std::make_unique<Device>(*this, types_, record);
    entity.device->optimistic(info_.optimistic(address));
    if (down_.empty()) entity.device->line_up();
  } else {
    if (entity.device->record().name != record.name) ++counters_.renames;
    entity.device->update(record);
  }
  report_();
}

void Devices::member_changed(const std::string& address) {
  changed_members_.insert(address);
  update_groups_.request();
}

void Devices::forget(const std::string& address, const std::string& why) {
  apply(topics_.remove(address));
  problems_.erase(address);
  const auto found = entities_.find(address);
  if (found == entities_.end()) return;
  member_changed(address);
  found->second.device->line_lost(why);  // answers what waits
  entities_.erase(found);
}

void Devices::left(const std::string& address, const std::string& reason) {
  if (entities_.contains(address)) ++counters_.leaves;
  unusable_.erase(address);
  forget(address, reason);
  host_.deliver(address, model::Leave{reason});
  report_();
}

void Devices::waiting(const bridge::DeviceRecord& record, const std::string& why) {
  forget(record.address, why);
  unusable_[record.address] = why;
  model::Join join;
  join.name = record.name;
  join.model = model_of(record);
  join.heard = false;
  join.problem = why;
  host_.deliver(record.address, std::move(join));
  report_();
}

void Devices::unreadable(const Error& error) {
  ++counters_.unreadable_lists;
  log_.warning("list", error.text);
  report_();
}

void Devices::groups(std::string_view payload) {
  auto read = bridge::read_groups(payload);
  if (!read) return unreadable(read.error());
  for (const auto& why : read->skipped) log_.warning("groups", why);
  new_groups_ = std::move(read->groups);
  update_groups_.request();
}

const bridge::DeviceRecord* Devices::member(const std::string& address) const {
  const auto found = entities_.find(address);
  return found == entities_.end() ? nullptr : &found->second.device->record();
}

void Devices::update_groups() {
  const auto find = [this](const std::string& address) { return member(address); };
  const auto members = std::exchange(changed_members_, {});
  if (auto groups = std::exchange(new_groups_, std::nullopt)) apply(groups_.replace(std::move(*groups), find));
  apply(groups_.members_changed(members, find));
}

void Devices::apply(const bridge::GroupChanges& changes) {
  for (const auto& address : changes.left) left(address, "the group was removed");
  for (const auto& record : changes.changed) changed(record);
}

void Devices::event(const bridge::BridgeEvent& event) {
  if (event.kind == bridge::BridgeEvent::Kind::kLeft) inventory_.leaving(event.address);
}

void Devices::info(const bridge::BridgeDescription& info) {
  info_ = info;
  for (const auto& [address, entity] : entities_) {
    entity.device->optimistic(info.optimistic(address));
  }
}

void Devices::received(const transport::MqttMessage& message) {
  const auto found = topics_.find(message.topic, message.payload);
  const auto at = found ? entities_.find(std::string(found->entity)) : entities_.end();
  if (at == entities_.end()) {
    ++counters_.unknown_topics;
    return report_();
  }
  auto& entity = at->second;
  if (!message.retained && !message.payload.empty()) inventory_.heard(at->first);
  if (found->kind == bridge::Topics::Kind::kAvailability) return availability(at->first, entity, message.payload);
  ++counters_.states;
  // Without the bridge, no message proves that a device is there.
  const bool stored = message.retained || !down_.empty();
  if (auto read = entity.device->state(message.payload, stored); !read) {
    ++counters_.bad_states;
    log_.warning("state " + at->first, fmt::format("{}: {}", model::quoted(message.topic), read.error().text));
  }
  report_();
}

/// Empty: the topic was cleared.
void Devices::availability(const std::string& address, Entity& entity, std::string_view payload) {
  if (payload.empty()) {
    entity.condition.available.reset();
    entity.available_later.reset();
    return;
  }
  const auto online = bridge::read_online(payload);
  if (!online) {
    ++counters_.bad_states;
    log_.warning(
        "availability " + address,
        fmt::format("{}: {}", model::quoted(entity.device->record().name + "/availability"), online.error().text));
    return report_();
  }
  entity.condition.available = *online;
  if (!down_.empty())
    entity.available_later = *online;
  else
    entity.device->availability(*online);
}

void Devices::line_up() {
  down_.clear();
  for (auto& [address, entity] : entities_) {
    entity.device->line_up();
    if (const auto online = std::exchange(entity.available_later, std::nullopt)) entity.device->availability(*online);
  }
}

void Devices::line_lost(const std::string& why) {
  down_ = why;
  inventory_.line_lost();
  for (const auto& [address, entity] : entities_) entity.device->line_lost(why);
}

Result<void> Devices::send(const Message& message) {
  const auto& address = message.destination.device;
  const auto found = entities_.find(address);
  if (const auto waits = unusable_.find(address); waits != unusable_.end())
    return fail(ErrorCode::kUnreachable, waits->second);
  if (found == entities_.end())
    return fail(ErrorCode::kNotFound, fmt::format("Zigbee2MQTT has no device {}", model::quoted(address)));
  const auto kind = message.kind();
  const bool command = kind == MessageKind::kActuate || kind == MessageKind::kSetProperty;
  if (!command && kind != MessageKind::kSample)
    return fail(ErrorCode::kUnsupported, fmt::format("a ZigBee device takes no {}", to_string(kind)));
  if (command && !down_.empty()) return fail(ErrorCode::kUnreachable, down_);
  if (command && problems_.contains(address)) return fail(ErrorCode::kUnreachable, problems_.at(address));
  return found->second.device->send(message);
}

Result<void> Devices::publish(const std::string& name, std::string_view verb, std::string payload) {
  if (!down_.empty()) return fail(ErrorCode::kUnreachable, down_);
  const bool set = verb == "set";
  ++(set ? counters_.sets : counters_.gets);
  report_();
  return line_.publish(set ? topics_.set(name) : topics_.get(name), std::move(payload));
}

void Devices::deliver(const std::string& address, model::Body body) {
  const auto found = entities_.find(address);
  if (const auto* updates = std::get_if<model::Updates>(&body)) {
    counters_.readings += updates->readings.size();
    if (found != entities_.end()) note(found->second.condition, *updates);
  }
  host_.deliver(address, std::move(body));
}

void Devices::note(Condition& condition, const model::Updates& updates) {
  for (const auto& reading : updates.readings) {
    if (reading.point.type != link_quality_) continue;
    if (const auto* number = std::get_if<double>(&reading.value)) condition.link_quality = *number;
    if (const auto* number = std::get_if<std::int64_t>(&reading.value))
      condition.link_quality = static_cast<double>(*number);
  }
}

bool Devices::take_poll(const std::string& address) {
  return poll_places_.take(address);
}

Devices::Condition Devices::condition(const std::string& address) const {
  const auto found = entities_.find(address);
  if (found == entities_.end()) return {};
  auto condition = found->second.condition;
  condition.last_seen = found->second.device->last_seen();
  condition.points = found->second.device->points().size();
  return condition;
}

void Devices::each(const std::function<void(const bridge::DeviceRecord& record, const std::string& why)>& call) const {
  inventory_.each(call);
  for (const auto& [address, record] : groups_.records()) call(record, {});
}

std::optional<std::string> Devices::find(std::string_view called) const {
  if (const auto* named = inventory_.find_named(called)) return named->address;
  std::string address(called.starts_with("0x") ? called.substr(2) : called);
  if (inventory_.find(address) != nullptr) return address;
  for (const auto& [group, record] : groups_.records()) {
    if (group == called || record.name == called) return group;
  }
  return std::nullopt;
}

}  // namespace rubicon::networks::zigbee
