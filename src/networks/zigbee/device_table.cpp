#include "networks/zigbee/device_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "networks/zigbee/bridge/settings.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

constexpr std::string_view kNotThereYet = "Zigbee2MQTT is not there yet";

std::string unknown_device(const std::string& address) {
  return fmt::format("Zigbee2MQTT has no device {}", model::quoted(address));
}

std::string model_of(const bridge::DeviceRecord& record) {
  return record.vendor.empty() || record.model.empty() ? record.vendor + record.model
                                                       : record.vendor + " " + record.model;
}

}  // namespace

DeviceTable::DeviceTable(network::NetworkHost& host, const TypeCatalogue& types, const ZigbeeOptions& options,
                         bridge::Topics& topics, BrokerLine& line, std::function<void()> changed)
    : host_(host),
      models_(types),
      topics_(topics),
      line_(line),
      report_(std::move(changed)),
      log_(host.limited_log()),
      poll_places_(host.scheduler(), options.polls_per_second),
      most_devices_(options.most_devices),
      down_(kNotThereYet),
      conflicts_(host.scheduler(), topics, log_, [this] { report_(); }),
      gaps_(log_),
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

void DeviceTable::apply(const bridge::Topics::Filters& filters) {
  for (const auto& filter : filters.added) std::ignore = line_.subscribe(filter);
  for (const auto& filter : filters.removed) std::ignore = line_.unsubscribe(filter);
}

void DeviceTable::changed(const bridge::DeviceRecord& record) {
  const auto& address = record.address;
  apply(topics_.put(address, record.name));
  conflicts_.put(address, record.name);
  unusable_.erase(address);
  if (!record.is_group()) gaps_.put(record);
  auto& entity = entities_[address];
  const bool same_leaves = entity.device && entity.device->record().leaves == record.leaves;
  if (!record.is_group() && !same_leaves) member_changed(address);
  if (!entity.device) {
    ++counters_.joins;
    entity.device = std::make_unique<Device>(*this, models_, record);
    apply_info(*entity.device);
    if (down_.empty()) entity.device->line_up(repeats_);
  } else {
    if (entity.device->record().name != record.name) ++counters_.renames;
    entity.device->update(record);
  }
  report_();
}

void DeviceTable::apply_info(Device& device) const {
  device.optimistic(info_.optimistic(device.record().address));
  device.bridge_decides(bridge::bridge_decides(info_, device.record()));
}

void DeviceTable::member_changed(const std::string& address) {
  changed_members_.insert(address);
  update_groups_.request();
}

void DeviceTable::forget(const std::string& address, const std::string& why) {
  apply(topics_.remove(address));
  conflicts_.remove(address);
  gaps_.remove(address);
  const auto found = entities_.find(address);
  if (found == entities_.end()) return;
  member_changed(address);
  found->second.device->line_lost(why);  // answers what waits
  entities_.erase(found);
}

void DeviceTable::left(const std::string& address, const std::string& reason) {
  if (entities_.contains(address)) ++counters_.leaves;
  unusable_.erase(address);
  forget(address, reason);
  host_.deliver(address, model::Leave{reason});
  report_();
}

void DeviceTable::waiting(const bridge::DeviceRecord& record, const std::string& why) {
  forget(record.address, why);
  unusable_[record.address] = why;
  model::Join join;
  join.name = base::one_line(record.name);
  join.model = model_of(record);
  join.heard = false;
  join.problem = why;
  host_.deliver(record.address, std::move(join));
  report_();
}

void DeviceTable::unreadable(const Error& error) {
  ++counters_.unreadable_lists;
  log_.warning("list", error.text);
  report_();
}

void DeviceTable::groups(std::string_view payload) {
  auto read = bridge::read_groups(payload);
  if (!read) return unreadable(read.error());
  for (const auto& why : read->skipped) log_.warning("groups", why);
  new_groups_ = std::move(read->groups);
  update_groups_.request();
}

const bridge::DeviceRecord* DeviceTable::member(const std::string& address) const {
  const auto found = entities_.find(address);
  return found == entities_.end() ? nullptr : &found->second.device->record();
}

void DeviceTable::update_groups() {
  const auto find = [this](const std::string& address) { return member(address); };
  const auto members = std::exchange(changed_members_, {});
  if (auto groups = std::exchange(new_groups_, std::nullopt)) {
    apply(groups_.replace(std::move(*groups), find));
    report_();
  }
  apply(groups_.members_changed(members, find));
  if (groups_.arrived()) answer_probed_groups();
}

void DeviceTable::answer_probed_groups() {
  for (const auto& address : std::exchange(probed_groups_, {})) {
    if (!groups_.records().contains(address)) left(address, "the group was removed");
  }
}

void DeviceTable::apply(const bridge::GroupChanges& changes) {
  for (const auto& address : changes.left) left(address, "the group was removed");
  for (const auto& record : changes.changed) {
    if (const auto why = bridge::why_waiting(record); why.empty())
      changed(record);
    else
      waiting(record, why);
  }
}

void DeviceTable::event(const bridge::BridgeEvent& event) {
  if (event.kind == bridge::BridgeEvent::Kind::kLeft) inventory_.leaving(event.address);
}

void DeviceTable::info(const bridge::BridgeDescription& info) {
  info_ = info;
  for (const auto& [address, entity] : entities_) apply_info(*entity.device);
}

void DeviceTable::removed(std::string_view called) {
  if (const auto address = find(called)) inventory_.leaving(*address);
}

void DeviceTable::received(const transport::MqttMessage& message) {
  const auto found = topics_.find(message.topic, message.payload);
  const auto at = found ? entities_.find(std::string(found->entity)) : entities_.end();
  if (at == entities_.end()) {
    ++counters_.unknown_topics;
    return report_();
  }
  auto& entity = at->second;
  if (!std::exchange(heard_, true)) report_();
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

bool DeviceTable::repeats(const transport::MqttMessage& message) const {
  const auto found = topics_.find(message.topic, message.payload);
  if (!found) return true;
  const auto at = entities_.find(std::string(found->entity));
  return found->kind == bridge::Topics::Kind::kState &&
         (at == entities_.end() || !at->second.device->may_have_event(message.payload));
}

/// Empty: the topic was cleared.
void DeviceTable::availability(const std::string& address, Entity& entity, std::string_view payload) {
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

void DeviceTable::connected() {
  heard_ = false;
  gets_before_ = counters_.gets;
  for (const auto& [address, entity] : entities_) entity.device->connected();
}

void DeviceTable::taken(std::string_view topic) {
  if (auto* device = commanded_by(topic)) device->taken();
}

void DeviceTable::not_taken(std::string_view topic, const std::string& why) {
  if (auto* device = commanded_by(topic)) device->not_taken(why);
}

Device* DeviceTable::commanded_by(std::string_view topic) const {
  if (!topic.ends_with("/set")) return nullptr;
  const auto found = std::find_if(entities_.begin(), entities_.end(), [&](const auto& one) {
    return topic == topics_.set(one.second.device->record().name);
  });
  return found == entities_.end() ? nullptr : found->second.device.get();
}

std::size_t DeviceTable::usable() const {
  return static_cast<std::size_t>(std::count_if(
      entities_.begin(), entities_.end(), [](const auto& one) { return !one.second.device->record().is_group(); }));
}

bool DeviceTable::answer_is_due() const {
  return counters_.gets != gets_before_ || std::any_of(entities_.begin(), entities_.end(), [&](const auto& one) {
           return bridge::bridge_decides(info_, one.second.device->record());
         });
}

void DeviceTable::line_up(bool repeats) {
  down_.clear();
  repeats_ = repeats;
  for (auto& [address, entity] : entities_) {
    entity.device->line_up(repeats_);
    if (const auto online = std::exchange(entity.available_later, std::nullopt)) entity.device->availability(*online);
  }
}

void DeviceTable::line_lost(const std::string& why) {
  down_ = why;
  inventory_.line_lost();
  for (const auto& [address, entity] : entities_) entity.device->line_lost(why);
}

/// The proxy asks for devices that it remembers: what was removed while the island did not run leaves.
Result<void> DeviceTable::probe(const Message& message) {
  const auto& address = message.destination.device;
  if (const auto found = entities_.find(address); found != entities_.end()) {
    auto asked = found->second.device->send(message);
    if (asked) acknowledge(message, model::Outcome::kSent, {});
    return asked;
  }
  if (!address.starts_with("group-")) {
    inventory_.expect(address);
  } else if (probed_groups_.size() < most_devices_) {
    probed_groups_.insert(address);
    update_groups_.request();
  }
  acknowledge(message, model::Outcome::kUndeliverable, unknown_device(address));
  return {};
}

void DeviceTable::acknowledge(const Message& message, model::Outcome outcome, std::string why) {
  Message answer;
  answer.source.device = message.destination.device;
  answer.destination = message.source;
  answer.body = model::Acknowledge{message.number, outcome, std::move(why)};
  host_.deliver(std::move(answer));
}

Result<void> DeviceTable::send(const Message& message) {
  const auto& address = message.destination.device;
  const auto kind = message.kind();
  if (kind == MessageKind::kProbe) return probe(message);
  const auto found = entities_.find(address);
  if (const auto waits = unusable_.find(address); waits != unusable_.end())
    return fail(ErrorCode::kUnreachable, waits->second);
  if (found == entities_.end()) return fail(ErrorCode::kNotFound, unknown_device(address));
  const bool command = kind == MessageKind::kActuate || kind == MessageKind::kSetProperty;
  if (!command && kind != MessageKind::kSample)
    return fail(ErrorCode::kUnsupported, fmt::format("a ZigBee device takes no {}", to_string(kind)));
  if (command && !down_.empty()) return fail(ErrorCode::kUnreachable, down_);
  if (const auto problem = problems().find(address); command && problem != problems().end())
    return fail(ErrorCode::kUnreachable, problem->second);
  return found->second.device->send(message);
}

Result<void> DeviceTable::publish(const std::string& name, std::string_view verb, std::string payload) {
  if (!down_.empty()) return fail(ErrorCode::kUnreachable, down_);
  const bool set = verb == "set";
  ++(set ? counters_.sets : counters_.gets);
  report_();
  return line_.publish(set ? topics_.set(name) : topics_.get(name), std::move(payload));
}

void DeviceTable::deliver(const std::string& address, model::Body body) {
  const auto found = entities_.find(address);
  if (const auto* updates = std::get_if<model::Updates>(&body)) {
    counters_.readings += updates->readings.size();
    if (found != entities_.end()) note(found->second.condition, *updates);
  }
  host_.deliver(address, std::move(body));
}

void DeviceTable::note(Condition& condition, const model::Updates& updates) {
  for (const auto& reading : updates.readings) {
    if (reading.point.type != link_quality_) continue;
    if (const auto* number = std::get_if<double>(&reading.value)) condition.link_quality = *number;
    if (const auto* number = std::get_if<std::int64_t>(&reading.value))
      condition.link_quality = static_cast<double>(*number);
  }
}

bool DeviceTable::take_poll(const std::string& address) {
  return poll_places_.take(address);
}

DeviceTable::Condition DeviceTable::condition(const std::string& address) const {
  const auto found = entities_.find(address);
  if (found == entities_.end()) return {};
  auto condition = found->second.condition;
  condition.last_seen = found->second.device->last_seen();
  condition.points = found->second.device->points().size();
  return condition;
}

void DeviceTable::each(
    const std::function<void(const bridge::DeviceRecord& record, const std::string& why)>& call) const {
  const auto with_problem = [&](const bridge::DeviceRecord& record, const std::string& why) {
    const auto problem = problems().find(record.address);
    call(record, why.empty() && problem != problems().end() ? problem->second : why);
  };
  inventory_.each(with_problem);
  for (const auto& [address, record] : groups_.records()) with_problem(record, bridge::why_waiting(record));
}

std::vector<DeviceTable::Unusable> DeviceTable::unusable_names() const {
  std::vector<Unusable> found;
  each([&](const bridge::DeviceRecord& record, const std::string& why) {
    if (!record.unusable_name.empty() || problems().contains(record.address))
      found.push_back({record.address, record.name, why});
  });
  return found;
}

std::optional<std::string> DeviceTable::find(std::string_view called) const {
  if (const auto* named = inventory_.find_named(called)) return named->address;
  std::string address(called.starts_with("0x") ? called.substr(2) : called);
  if (inventory_.find(address) != nullptr) return address;
  for (const auto& [group, record] : groups_.records()) {
    if (group == called || record.name == called) return group;
  }
  return std::nullopt;
}

}  // namespace rubicon::networks::zigbee
