#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "networks/zigbee/bridge/groups.h"
#include "networks/zigbee/bridge/inventory.h"
#include "networks/zigbee/bridge/messages.h"
#include "networks/zigbee/bridge/topics.h"
#include "networks/zigbee/broker_line.h"
#include "networks/zigbee/device.h"
#include "networks/zigbee/poll_places.h"
#include "networks/zigbee/unusable.h"
#include "networks/zigbee/zigbee_options.h"

namespace rubicon::networks::zigbee {

/// The devices and groups of a bridge: made by its lists, reached by their topics. They outlive every loss of the line.
class DeviceTable final : public DeviceHost {
 public:
  struct Counters {
    std::uint64_t joins = 0, leaves = 0, renames = 0;
    std::uint64_t states = 0, bad_states = 0, readings = 0;
    std::uint64_t sets = 0, gets = 0;
    std::uint64_t unknown_topics = 0, unreadable_lists = 0;
  };
  /// `changed` is called in turns of their own when counters or problems() changed.
  DeviceTable(network::NetworkHost& host, const TypeCatalogue& types, const ZigbeeOptions& options,
              bridge::Topics& topics, BrokerLine& line, std::function<void()> changed);

  // What the bridge publishes.
  void list(std::string_view payload, bool retained) { inventory_.list(payload, retained); }
  void groups(std::string_view payload);
  void event(const bridge::BridgeEvent& event);
  void info(const bridge::BridgeDescription& info);
  /// The bridge removed the device of this address or name: it leaves when a list lacks it.
  void removed(std::string_view called);
  /// A message of an entity; retained or not.
  void received(const transport::MqttMessage& message);
  /// Whether a later message of the topic makes this one superfluous; not so availability and events.
  bool repeats(const transport::MqttMessage& message) const;

  /// The bridge is there: commands can be sent, and what devices can be asked for is asked.
  /// `repeats`: BridgeState::repeats().
  void line_up(bool repeats);
  /// The bridge or the broker is gone.
  void line_lost(const std::string& why);
  /// Actuate, SetProperty, Sample, Probe of a device. A Probe of a device that the lists lack is answered by its Leave.
  Result<void> send(const Message& message);
  void polls_per_second(unsigned most) { poll_places_.per_second(most); }

  // DeviceHost.
  Result<void> publish(const std::string& name, std::string_view verb, std::string payload) override;
  void deliver(const std::string& address, model::Body body) override;
  Scheduler& scheduler() override { return host_.scheduler(); }
  bool take_poll(const std::string& address) override;

  /// What is known of a device besides its record.
  struct Condition {
    std::optional<bool> available;  ///< as the bridge reported; nullopt = it did not
    WallTime last_seen{};           ///< of its state messages; zero = not known
    std::optional<double> link_quality;
    std::size_t points = 0;
  };
  Condition condition(const std::string& address) const;
  const bridge::Inventory& inventory() const { return inventory_; }
  /// A device or group that its friendly name makes unusable.
  struct Unusable {
    std::string address, name, why;
  };
  /// In the order of their addresses.
  std::vector<Unusable> unusable_names() const;
  /// Devices and groups in the order of their addresses; `why` is empty if it is usable.
  void each(const std::function<void(const bridge::DeviceRecord& record, const std::string& why)>& call) const;
  /// Address of the device or group that a person calls so: an address, with or without `0x`, or a friendly name.
  std::optional<std::string> find(std::string_view called) const;
  const Counters& counters() const { return counters_; }
  std::size_t size() const { return entities_.size(); }
  /// Names that have no topics of their own, one sentence each.
  const std::map<std::string, std::string>& problems() const { return conflicts_.problems(); }
  const DefinitionGaps& gaps() const { return gaps_; }
  bool lists_arrived() const { return listed_; }
  /// As bridge/info reports it: false if a setting of the bridge prevents it.
  bool publishes_states() const { return info_.output != "attribute"; }
  bool bridge_retains() const { return info_.retained; }
  const bridge::Groups& known_groups() const { return groups_; }

  /// The broker is connected (again): nothing was heard on this connection.
  void connected();
  /// The broker took a message to this topic: a command of a device without an echo counts as sent, and is answered
  /// kSent.
  void taken(std::string_view topic);
  /// The broker did not take a message to this topic: a command of a device ends with this reason.
  void not_taken(std::string_view topic, const std::string& why);
  /// A state or the availability of a device or group was received on this connection, stored or new.
  bool heard() const { return heard_; }
  /// Devices that can be used, without groups.
  std::size_t usable() const;
  /// Whether one of them should have been heard within seconds: the bridge publishes its availability, or it was asked.
  bool answer_is_due() const;

 private:
  struct Entity {
    std::unique_ptr<Device> device;
    Condition condition;
    std::optional<bool> available_later;  ///< came while the bridge was not there
  };
  void changed(const bridge::DeviceRecord& record);
  void left(const std::string& address, const std::string& reason);
  void waiting(const bridge::DeviceRecord& record, const std::string& why);
  void availability(const std::string& address, Entity& entity, std::string_view payload);
  void unreadable(const Error& error);
  void apply(const bridge::Topics::Filters& filters);
  void member_changed(const std::string& address);
  void update_groups();
  void apply(const bridge::GroupChanges& changes);
  const bridge::DeviceRecord* member(const std::string& address) const;
  /// That takes its set messages at this topic; null: none.
  Device* commanded_by(std::string_view topic) const;
  void note(Condition& condition, const model::Updates& updates);
  void apply_info(Device& device) const;
  Result<void> probe(const Message& message);
  void acknowledge(const Message& message, model::Outcome outcome, std::string why);
  void answer_probed_groups();
  void forget(const std::string& address, const std::string& why);

  network::NetworkHost& host_;
  exposes::PointsOfModels models_;
  bridge::Topics& topics_;
  BrokerLine& line_;
  std::function<void()> report_;
  base::LimitedLog log_;
  PollPlaces poll_places_;
  std::size_t most_devices_;
  std::string down_;     ///< why the bridge is not there; empty = it is
  bool repeats_ = true;  ///< of the last line_up()
  bool listed_ = false;
  bool heard_ = false;
  std::uint64_t gets_before_ = 0;  ///< on earlier connections
  bridge::BridgeDescription info_;
  bridge::Groups groups_;
  std::optional<std::vector<bridge::Group>> new_groups_;  ///< a list that update_groups() takes
  std::set<std::string> changed_members_;                 ///< since the last update_groups()
  std::set<std::string> probed_groups_;                   ///< which no list had so far
  std::map<std::string, std::string> unusable_;           ///< devices that wait: address, why
  Counters counters_;
  TypeId link_quality_{};
  std::unordered_map<std::string, Entity> entities_;
  TopicConflicts conflicts_;
  DefinitionGaps gaps_;
  base::OncePerTurn update_groups_;
  bridge::Inventory inventory_;
};

}  // namespace rubicon::networks::zigbee
